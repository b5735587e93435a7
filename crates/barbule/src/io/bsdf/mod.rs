//! Measured materials: `.bsdf` files of the RGL database, and MERL's `.binary`.

mod tensors;

use tensors::{Written, WrittenValues, is_tensor_file};

use crate::bsdf::MeasuredTables;
use crate::bsdf::measured::{Channels, Grid, MERL_SIZE, Merl, Rgl, RglArrays};
use crate::{Error, Result};

/// The largest file that is read.
pub const LARGEST_BSDF: u64 = 2 << 30;

/// What MERL's numbers of red, green and blue are multiplied by.
const MERL_SCALE: [f64; 3] = [1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0];

/// Reads the tables of a measured material from a file's bytes, an RGL `.bsdf` or a MERL `.binary`, by what is in it.
///
/// # Errors
/// Neither, or a damaged one.
pub fn decode_bsdf(bytes: &[u8]) -> Result<MeasuredTables> {
    if is_tensor_file(bytes) {
        return Ok(MeasuredTables::Rgl(Box::new(Rgl::new(rgl_arrays(bytes)?)?)));
    }
    let head: Vec<usize> =
        bytes.chunks_exact(4).take(3).filter_map(|four| four.try_into().ok()).map(of_u32).collect();
    if head == MERL_SIZE {
        return merl(&bytes[12..]).map(|merl| MeasuredTables::Merl(Box::new(merl)));
    }
    Err(Error::input("is neither an RGL .bsdf nor a MERL .binary of 90 × 90 × 180 values"))
}

/// The arrays of a `.bsdf`.
///
/// # Errors
/// One that is missing, of another type, or of a shape that does not fit.
pub fn rgl_arrays(bytes: &[u8]) -> Result<RglArrays> {
    let fields = tensors::decode(bytes)?;
    let singles = |name: &str, dimensions: usize| {
        let (shape, tensor) = fields.get(name).ok_or_else(|| Error::input(format!("has no field {name}")))?;
        match tensor.singles() {
            Some(values) if shape.len() == dimensions => Ok((&shape[..], values)),
            _ => Err(Error::input(format!(
                "field {name} is no array of {dimensions} dimensions of 32-bit floats"
            ))),
        }
    };
    let grid = |name: &str| {
        let (shape, values) = singles(name, 2)?;
        Ok::<_, Error>(Grid { size: [shape[0], shape[1]], values })
    };
    let (vndf_shape, vndf) = singles("vndf", 4)?;
    let (shape, luminance) = singles("luminance", 4)?;
    let (channels, values) = if fields.contains_key("spectra") {
        (Channels::Wavelengths(singles("wavelengths", 1)?.1), singles("spectra", 5)?.1)
    } else if fields.contains_key("rgb") {
        (Channels::Rgb, singles("rgb", 5)?.1)
    } else {
        return Err(Error::input("has no field spectra or rgb"));
    };
    let jacobian = fields.get("jacobian").and_then(|(_, tensor)| tensor.bytes()).and_then(<[u8]>::first);
    Ok(RglArrays {
        phi_i: singles("phi_i", 1)?.1,
        theta_i: singles("theta_i", 1)?.1,
        channels,
        ndf: grid("ndf")?,
        sigma: grid("sigma")?,
        vndf_size: [vndf_shape[2], vndf_shape[3]],
        vndf,
        size: [shape[2], shape[3]],
        luminance,
        values,
        has_jacobian: jacobian.is_none_or(|flag| *flag != 0),
    })
}

/// The bytes of a `.bsdf`; `description` is a text of what it is. Readers of other programs ignore what they do not know.
#[must_use]
pub fn encode_bsdf(arrays: &RglArrays, description: &str) -> Vec<u8> {
    let [phis, thetas] = [arrays.phi_i.len(), arrays.theta_i.len()];
    let singles = |name, shape: &[usize], values| {
        let shape = shape.to_vec();
        Written { name, shape, values: WrittenValues::Singles(values) }
    };
    let bytes = |name, values: &'static [u8]| Written {
        name,
        shape: vec![values.len()],
        values: WrittenValues::Bytes(values),
    };
    let [rows, columns] = arrays.size;
    let nodes = |size: [usize; 2]| [phis, thetas, size[0], size[1]];
    let mut fields = vec![
        Written {
            name: "description",
            shape: vec![description.len()],
            values: WrittenValues::Bytes(description.as_bytes()),
        },
        bytes("jacobian", if arrays.has_jacobian { &[1] } else { &[0] }),
        singles("phi_i", &[phis], &arrays.phi_i),
        singles("theta_i", &[thetas], &arrays.theta_i),
        singles("ndf", &arrays.ndf.size, &arrays.ndf.values),
        singles("sigma", &arrays.sigma.size, &arrays.sigma.values),
        singles("vndf", &nodes(arrays.vndf_size), &arrays.vndf),
        singles("luminance", &nodes(arrays.size), &arrays.luminance),
    ];
    match &arrays.channels {
        Channels::Wavelengths(nm) => {
            fields.push(singles("wavelengths", &[nm.len()], nm));
            fields.push(singles("spectra", &[phis, thetas, nm.len(), rows, columns], &arrays.values));
        }
        Channels::Rgb => fields.push(singles("rgb", &[phis, thetas, 3, rows, columns], &arrays.values)),
    }
    tensors::encode(&fields)
}

fn merl(bytes: &[u8]) -> Result<Merl> {
    let per_channel = MERL_SIZE.iter().product::<usize>();
    if bytes.len() != 8 * 3 * per_channel {
        return Err(Error::input("is a MERL .binary that ends too early, or too late"));
    }
    let of = |(k, eight): (usize, &[u8])| {
        let mut own = [0; 8];
        own.copy_from_slice(eight);
        (f64::from_le_bytes(own) * MERL_SCALE[k / per_channel]) as f32
    };
    Merl::new(bytes.chunks_exact(8).enumerate().map(of).collect())
}

fn of_u32(four: [u8; 4]) -> usize {
    u32::from_le_bytes(four) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arrays(channels: Channels) -> RglArrays {
        let count = if channels == Channels::Rgb { 3 } else { 2 };
        let some = |count: usize| (0..count).map(|k| 0.5 + (k % 7) as f32).collect::<Vec<_>>();
        RglArrays {
            phi_i: vec![-3.1, 0.0, 3.1],
            theta_i: vec![0.0, 1.0],
            channels,
            ndf: Grid { size: [3, 4], values: some(12) },
            sigma: Grid { size: [2, 2], values: some(4) },
            vndf_size: [3, 4],
            vndf: some(72),
            size: [2, 3],
            luminance: some(36),
            values: some(36 * count),
            has_jacobian: true,
        }
    }

    #[test]
    fn files_come_back() {
        for channels in [Channels::Rgb, Channels::Wavelengths(vec![400.0, 700.0])] {
            let own = arrays(channels);
            let bytes = encode_bsdf(&own, "a test");
            assert_eq!(rgl_arrays(&bytes).unwrap(), own);
            assert!(matches!(decode_bsdf(&bytes), Ok(MeasuredTables::Rgl(_))));
        }
    }

    /// Each is one sentence, wherever a file ends, and whatever it says of its sizes.
    #[test]
    fn damaged_files_are_refused() {
        let bytes = encode_bsdf(&arrays(Channels::Rgb), "a test");
        for end in (0..400).chain([bytes.len() - 1]) {
            assert!(decode_bsdf(&bytes[..end]).is_err(), "{end}");
        }
        let refused = |spoil: &dyn Fn(&mut Vec<u8>)| {
            let mut bytes = bytes.clone();
            spoil(&mut bytes);
            decode_bsdf(&bytes).unwrap_err().to_string()
        };
        let place = |name: &str| bytes.windows(name.len()).position(|w| w == name.as_bytes()).unwrap();
        assert!(refused(&|b| b[12] = 2).contains("version 1.0"));
        assert!(refused(&|b| b[14..18].copy_from_slice(&u32::MAX.to_le_bytes())).contains("fields"));
        let sigma = place("sigma");
        assert!(refused(&|b| b[sigma] = b'x').contains("has no field sigma"));
        assert!(refused(&|b| b[sigma + 7] = 11).contains("field sigma"));
        // The offset, and a side, beyond anything.
        assert!(refused(&|b| b[sigma + 8..sigma + 16].fill(0xff)).contains("beyond the end"));
        assert!(refused(&|b| b[sigma + 16..sigma + 24].fill(0xff)).contains("beyond the end"));
        assert!(decode_bsdf(b"picture").unwrap_err().to_string().contains("neither"));
    }

    #[test]
    fn merl_is_scaled_by_channel() {
        let count = 3 * MERL_SIZE.iter().product::<usize>();
        let mut bytes: Vec<u8> = MERL_SIZE.iter().flat_map(|side| (*side as u32).to_le_bytes()).collect();
        for _ in 0..count {
            bytes.extend(300.0f64.to_le_bytes());
        }
        let Ok(MeasuredTables::Merl(merl)) = decode_bsdf(&bytes) else { panic!("is no MERL") };
        let up = crate::DVec3::new(0.1, 0.2, 0.9).normalize();
        for (found, scale) in merl.f(up, up).into_iter().zip(MERL_SCALE) {
            assert!((found - 300.0 * scale).abs() < 1e-6);
        }
        bytes.pop();
        assert!(decode_bsdf(&bytes).unwrap_err().to_string().contains("ends too early"));
    }
}
