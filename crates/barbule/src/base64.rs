//! Bytes as letters (RFC 4648), as files of text hold them.

/// The letters of some bytes.
#[must_use]
pub(crate) fn encoded(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let word = chunk.iter().fold(0_u32, |word, b| word << 8 | u32::from(*b)) << (8 * (3 - chunk.len()));
        for i in 0..4 {
            let letter = LETTERS[(word >> (18 - 6 * i) & 63) as usize];
            out.push(if i <= chunk.len() { letter as char } else { '=' });
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_that_of_rfc_4648() {
        let of = |t: &str| encoded(t.as_bytes());
        assert_eq!(
            (of(""), of("f"), of("fo"), of("foo")),
            ("".into(), "Zg==".into(), "Zm8=".into(), "Zm9v".into())
        );
        assert_eq!(of("foobar"), "Zm9vYmFy");
    }
}
