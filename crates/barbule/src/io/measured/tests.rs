//! Files as people have them, and files that nobody should have.

mod roles;

use super::*;

fn read(text: &str) -> Measured {
    parse_measured("m.csv", text.as_bytes(), None, None).unwrap()
}

fn of(text: &str, column: &str) -> Result<Measured> {
    parse_measured("m.csv", text.as_bytes(), Some(column), None)
}

fn refusal(text: &str) -> String {
    let error = parse_measured("m.csv", text.as_bytes(), None, None).unwrap_err();
    let message = error.to_string();
    assert!(error.is_input() && message.starts_with("m.csv: ") && message.chars().count() < 600, "{message}");
    message
}

fn names(measured: &Measured) -> Vec<&str> {
    measured.samples.iter().map(|s| s.name.as_str()).collect()
}

const PLAIN: &str = "nm,R\n400,0.1\n500,0.3\n";

#[test]
fn the_same_numbers_are_read_from_every_kind_of_table() {
    let plain = read(PLAIN);
    assert_eq!(plain.mean.value(450.0), Some(0.2));
    for same in [
        "400,0.1\n500,0.3",
        "\u{feff}wl;swallow\r\n400;0,1\r\n500;0,3\r\n",
        "wl\tR\r400\t0.1\r500\t0.3\r",
        "# made by hand\nlambda R\n\n400   0.1\n500   0.3",
        "\"\",\"wl\",\"swallow1\"\n\"1\",400,0.1\n\"2\",500,0.3\n",
        "\"wl\" \"s1\"\n\"1\" 400 0.1\n\"2\" 500 0.3\n",
        "Wavelength (nm),%R\n400,10\n500,30",
        "Wavelength [nm];Reflectance [%]\n400,0;10,0\n500,0;30,0",
        "\"wavelength, nm\",\"R\"\n\"400,0\",\"0,1\"\n\"500,0\",\"0,3\"",
        "wl,R\n500,0.3\n400,0.1",
        "R,wl\n0.1,400\n0.3,500",
        "um,R\n0.4,0.1\n0.5,0.3",
        "wavenumber (1/cm),R\n25000,0.1\n20000,0.3",
        "nm,mean,std\n400,0.1,0.01\n500,0.3,0.02",
        "angle_deg,wavelength_nm,mean,std\n0,400,0.1,0\n0,500,0.3,0",
        "wl,s\n400,10%\n500,30%",
        "nm,R\n390,NA\n400,0.1\n500,0.3\n",
        "wl,R,\n400,0.1,\n500,0.3,\n",
        "λ/nm | R\n400 | 0.1\n500 | 0.3",
        "0;400;0.1\n1;500;0.3",
    ] {
        let found = read(same);
        assert_eq!(found.mean, plain.mean, "{same}: {}", found.reading);
        assert!(found.reading.starts_with("m.csv: ") && !found.reading.contains('\n'));
    }
    let wide: Vec<u8> =
        std::iter::once(0xfeff).chain(PLAIN.encode_utf16()).flat_map(u16::to_le_bytes).collect();
    assert_eq!(parse_measured("m.txt", &wide, None, None).unwrap().mean, plain.mean);
    let latin = b"\xb5m;R\n0.4;0.1\n0.5;0.3";
    assert_eq!(parse_measured("m.txt", latin, None, None).unwrap().mean, plain.mean);
}

#[test]
fn what_is_guessed_is_said() {
    let found = read("wl;back 1;back 2\n400;8,5;9\n500;12;15,5\n700;30;32\n");
    assert_eq!(
        found.reading,
        "m.csv: semicolons, decimal commas; wavelengths from 'wl' (400–700 nm); 2 samples, 'back 1' and 'back 2'; percent divided by 100, since they reach 32"
    );
    assert_eq!(names(&found), ["back 1", "back 2"]);
    assert_eq!(found.mean.values(), [0.0875, 0.1375, 0.31]);
    assert!((found.std.unwrap()[2] - 0.02 / 2f64.sqrt()).abs() < 1e-12);
    for (text, part) in [
        (
            "wl,R\n250,0.1\n300,0.1\n500,0.3\n900,2",
            "300–500 nm kept; 1 sample, 'R'; values to 0.3 taken as parts of 1",
        ),
        ("\"\",\"wl\",\"s\"\n\"1\",400,0.1\n\"2\",500,0.3", "row numbers left out"),
        ("wl,R\n500,0.3\n400,0.1", "falling wavelengths turned round"),
        ("wl,R\n400,0.1\n400,0.2\n500,0.3", "1 doubled wavelength averaged"),
        ("wl,R\n400,0.1\n450,NA\n500,0.3", "1 line with missing values left out"),
        ("wl,R\n400,-0.01\n500,0.3", "1 value below zero"),
        ("um,R\n0.4,0.1\n0.5,0.3", "wavelengths from 'um' (400–500 nm, µm turned into nm)"),
        ("400,0.1\n500,0.3", "commas; wavelengths from column 1 (400–500 nm)"),
        ("wl,R,dark,reference\n400,0.1,5,900\n500,0.3,6,950", "'dark', 'reference' left out"),
    ] {
        let found = read(text);
        assert!(found.reading.contains(part), "{}", found.reading);
    }
    let overruled = parse_measured("m.csv", b"wl,R\n400,0.9\n500,1.2", None, Some(Scale::Percent)).unwrap();
    assert_eq!(overruled.mean.values(), [0.9 / 100.0, 1.2 / 100.0]);
    let bright = parse_measured("m.csv", b"wl,R\n400,0.9\n500,1.8", None, Some(Scale::Fraction)).unwrap();
    assert_eq!(bright.mean.values(), [0.9, 1.8]);
}

#[test]
fn holes_in_a_spectrum_are_said() {
    let table = |is_known: &dyn Fn(usize) -> bool, line: &dyn Fn(usize) -> String| {
        (400..=700).step_by(5).filter(|nm| is_known(*nm)).map(line).collect::<String>()
    };
    let plain = |nm: usize| format!("{nm},0.2\n");
    let outside = |nm: usize| !(455..=615).contains(&nm);
    let said = "no values from 450 to 620 nm: a straight line is taken there";
    let one = read(&format!("wl,R\n{}", table(&outside, &plain)));
    assert!(one.reading.contains(&format!("(400–700 nm); {said}; 1 sample, 'R'")), "{}", one.reading);
    // Lines without a number are a hole too.
    let missing = |nm: usize| if outside(nm) { plain(nm) } else { format!("{nm},NA\n") };
    let found = read(&format!("wl,R\n{}", table(&|_| true, &missing)));
    assert!(found.reading.contains("33 lines with missing values left out"), "{}", found.reading);
    assert!(found.reading.contains(said) && found.mean == one.mean, "{}", found.reading);
    let two = read(&format!("wl,R\n{}", table(&|nm| outside(nm) && !(660..=690).contains(&nm), &plain)));
    assert!(two.reading.contains("450 to 620 nm, and 1 more hole: a straight"), "{}", two.reading);
    // Where samples are brought together it is the common wavelengths that count.
    let own = |nm: usize| format!("{nm},0.2,{},0.3\n", nm + 1);
    let together = read(&format!("wl1,a,wl2,b\n{}", table(&outside, &own)));
    assert!(together.reading.contains(said), "{}", together.reading);
    // Coarse tables have none, nor have even steps in 1/cm.
    let waves: String = (13..=33).map(|thousands| format!("{},0.2\n", 1000 * thousands)).collect();
    for whole in [
        format!("wl,R\n{}", table(&|_| true, &plain)),
        "wl,R\n400,0.1\n420,0.1\n440,0.1\n500,0.1\n520,0.1\n".to_owned(),
        "wl,R\n400,0.1\n404,0.1\n408,0.1\n428,0.1\n".to_owned(),
        "wl,R\n400,0.1\n700,0.1\n".to_owned(),
        format!("wavenumber (1/cm),R\n{waves}"),
    ] {
        let found = read(&whole);
        assert!(!found.reading.contains("no values"), "{}", found.reading);
    }
}

#[test]
fn spectrometers_text_is_read() {
    let ocean = "SpectraSuite Data File\n++++++++++++++++++++++++++++++++++++\nDate: Tue Jan 01 12:00:00 CET 2019\nUser: x\nIntegration Time (usec): 100000 (USB2+F00001)\nNumber of Pixels in Processed Spectrum: 4\n>>>>>Begin Processed Spectral Data<<<<<\n178.10\t-381.2\n400.00\t8.00\n500.00\t12.00\n600.00\t9.00\n>>>>>End Processed Spectral Data<<<<<\n";
    let found = read(ocean);
    assert_eq!(found.mean.values(), [0.08, 0.12, 0.09]);
    assert!(found.reading.contains("spectrometer text, tabs"), "{}", found.reading);
    let jaz = "Jaz Data File\n++++\nDate: x\n>>>>>Begin Processed Spectral Data<<<<<\nW\tD\tR\tS\tP\n400,0\t90\t4000\t500\t10,5\n500,0\t91\t4100\t600\t12,5\n>>>>>End Processed Spectral Data<<<<<\n";
    assert_eq!(read(jaz).mean.values(), [0.105, 0.125]);
    let avantes = "Integration time [ms]:  50.00\nAveraging Nr. [scans]: 10\nData measured with spectrometer [name]: 0807012U1\n\nWave   ;Sample   ;Dark     ;Reference;Reflectance\n[nm]   ;[counts] ;[counts] ;[counts] ;[%]\n\n 400.290;   820.000;   700.0; 5000.0;  10.0\n 500.300;   900.000;   710.0; 5100.0;  12.0\n";
    let found = read(avantes);
    assert_eq!(names(&found), ["Reflectance [%]"]);
    assert_eq!(found.mean.values(), [0.1, 0.12]);
}

#[test]
fn one_of_several_columns_is_named_or_counted() {
    let text = "wl;a;b b\n400;0,1;0,2\n500;0,3;0,4\n";
    for (column, expected) in [("a", 0.1), ("B b", 0.2), ("2", 0.1), ("3", 0.2)] {
        assert_eq!(of(text, column).unwrap().mean.value(400.0), Some(expected), "{column}");
    }
    for (column, part) in [
        ("c", "there is no such column, did you mean 'a'?; there are 3 columns: 'wl', 'a', 'b b'"),
        ("1", "is the wavelength"),
        ("4", "no such column"),
        ("wl", "is the wavelength"),
    ] {
        let message = of(text, column).unwrap_err().to_string();
        assert!(message.contains(part), "{message}");
    }
    let birds = "wl,white throat,dark,bird r,bird l,back_sd\n400,0.1,0.2,0.3,0.4,0\n500,0.3,0.4,0.5,0.6,0\n";
    let message = refusal(birds);
    assert!(message.contains("'white throat', 'dark', 'bird r', 'bird l' are not all"), "{message}");
    let birds = read(&birds.replace("dark", "dark morph"));
    assert_eq!(names(&birds), ["white throat", "dark morph", "bird r", "bird l"]);
    assert!(birds.reading.contains("'back_sd' left out"), "{}", birds.reading);
    assert_eq!(of("wl,raw\n400,0.1\n500,0.3", "raw").unwrap().samples.len(), 1);
}

#[test]
fn what_can_be_read_in_two_ways_is_refused_with_the_choice() {
    for (text, part) in [
        ("", "no lines of numbers"),
        ("nm,R\n", "no lines of numbers"),
        ("400\n500\n", "line 1: '400' is not a wavelength and a reflectance"),
        ("nm,R\n400,0.1\n450,x\n500,0.3\n", "line 3, column 2: 'x' is not a finite number"),
        ("nm,R\n400,0.1\n450,1e999\n500,0.3\n", "line 3, column 2: '1e999'"),
        ("nm,R\n400,0.1\n500,0.3\n600,0.1,7\n", "line 4: has 3 columns, but line 2 has 2"),
        (
            "nm,R\n400,0.1\n500,0.3\n450,0.2\n",
            "line 4: the wavelength 450 nm is out of order beside 500 nm in line 3",
        ),
        ("nm,R\n0.4,0.1\n0.5,0.3\n", "look like micrometres"),
        ("0.4,0.1\n0.5,0.3\n", "looks like micrometres"),
        ("nm,R\n-400,0.1\n500,0.3\n", "line 2: the wavelength -400"),
        ("nm,R\n100,0.1\n200,0.3\n", "fewer than two lie within 300 to 830 nm"),
        ("nm,R\n400,1e300\n500,0.3\n", "is no reflectance"),
        ("nm,R\n400,-1e300\n500,0.3\n", "is no reflectance"),
        ("nm,R\n400,30000\n500,40000\n", "counts"),
        ("nm,R\n400,-0.4\n500,0.3\n", "mostly below zero"),
        (
            "nm,R,depth\n400,0.1,3\n500,0.3,3\n",
            "'R', 'depth' are not all reflectances by their names; name one with `column`",
        ),
        ("nm,absorbance\n400,0.1\n500,0.3\n", "column 'absorbance' is no reflectance by its name"),
        ("wl,wl,R\n400,410,0.1\n500,510,0.3\n", "are both wavelengths, and differ"),
        // The first column is the wavelength by custom.
        ("400,410,0.1\n500,400,0.3\n600,700,0.1", "sample 2 is 30 times lower than sample 1 in the mean"),
        ("wl,%back,b\n400,10,0.9\n500,30,1.2\n", "or all percent; write % into the name"),
        ("wl,R\n400,0,0,1\n500,0,0,3\n", "decimal commas"),
        ("nm,std\n400,0.1\n500,0.3\n", "no column of reflectance"),
        ("PK\u{3}\u{4}xl", "save the sheet as CSV"),
        ("a\0b", "is not text"),
    ] {
        let message = refusal(text);
        assert!(message.contains(part), "{text:?}: {message}");
    }
}

fn jdx(more: &str, data: &str) -> String {
    format!(
        "##TITLE= swallow\n##JCAMP-DX= 4.24 $$ by hand\n##DATA TYPE= UV-VIS SPECTRUM\n##XUNITS= NANOMETERS\n##YUNITS= REFLECTANCE\n{more}\n{data}\n##END=\n"
    )
}

/// The values 10, 11, 12, 12, 12, 11, 9 in every form of the standard.
#[test]
fn all_forms_of_jcamp_give_the_same_numbers() {
    let head = "##XFACTOR= 1.0\n##YFACTOR= 0.01\n##FIRSTX= 400\n##LASTX= 460\n##NPOINTS= 7";
    let expected = [10.0, 11.0, 12.0, 12.0, 12.0, 11.0, 9.0].map(|v| v * 0.01);
    for data in [
        "##XYDATA= (X++(Y..Y))\n400 10 11 12 12\n440 12 11 9",
        "##XYDATA= (X++(Y..Y))\n400 1.0E1 11.0 1.2e+01 12\n440 12 11 9",
        "##XYDATA=(X++(Y..Y))\n400+10+11+12+12\n440+12+11+9",
        "##XYDATA=(X++(Y..Y))\n400A0A1A2A2\n440A2A1I",
        "##XYDATA=(X++(Y..Y))\n400A0A1A2U\n450A1I",
        "##XYDATA=(X++(Y..Y))\n400A0JJ%%\n440A2jk",
        "##XYDATA=(X++(Y..Y))\n400A0JT%T\n440A2jk\n460I $$ checkpoint",
        "##XYPOINTS= (XY..XY)\n400,10; 410,11; 420,12\n430,12 440,12\n450 11, 460 9",
    ] {
        let found = parse_measured("s.jdx", jdx(head, data).as_bytes(), None, None).unwrap();
        assert_eq!(
            found.mean.wavelengths().nm(),
            [400.0, 410.0, 420.0, 430.0, 440.0, 450.0, 460.0],
            "{data}"
        );
        for (value, expected) in found.mean.values().iter().zip(expected) {
            assert!((value - expected).abs() < 1e-15, "{data}: {found:?}");
        }
        assert_eq!(found.samples[0].name, "swallow");
    }
    let waves = "##TITLE= s\n##XUNITS= 1/CM\n##YUNITS= % REFLECTANCE\n##FIRSTX= 20000\n##LASTX= 25000\n##XYDATA=(X++(Y..Y))\n20000 30 20 10\n##END=";
    let found = parse_measured("s.jdx", waves.as_bytes(), None, None).unwrap();
    assert_eq!(
        (found.mean.wavelengths().range_nm(), found.mean.values()),
        ((400.0, 500.0), &[0.1, 0.2, 0.3][..])
    );
    assert!(
        found.reading.contains("1/cm turned into nm") && found.reading.contains("percent divided by 100")
    );
}

#[test]
fn spoilt_jcamp_is_refused() {
    let head = "##FIRSTX= 400\n##LASTX= 420\n##NPOINTS= 3";
    let data = "##XYDATA=(X++(Y..Y))\n400 10 11 12";
    for (more, data, part) in [
        ("##FIRSTX= 400\n##LASTX= 420\n##NPOINTS= 4", data, "NPOINTS is 4, but the data have 3 points"),
        (head, "##XYDATA=(X++(Y..Y))\n400A0J\n410A2J", "but the line before ends at 11"),
        (head, "##XYDATA=(X++(Y..Y))\n400 10 11\n440 12", "is a line missing?"),
        (head, "##XYDATA=(X++(Y..Y))\n400 10 x 12", "line 10: 'x 12' is not a finite number"),
        (head, "##XYDATA=(X++(Y..Y))\n400 10 ? 12", "not known"),
        (head, "##XYDATA=(X++(Y..Y))\n400J1", "begins with a difference"),
        (head, "##XYDATA=(X++(Y..Y))\n400A0s9999999999", "repetitions are too many"),
        (head, "##XYDATA=(X++(Y..Y))\n400A0s9999\n410A0s9999\n", "over 100000 points"),
        (head, "##XYDATA=(R++(A..A))\n400 10", "the form '(R++(A..A))' is not read"),
        (head, "##XYPOINTS=(XY..XY)\n400 10 410", "a position without a value"),
        (head, "##NTUPLES= x", "NTUPLES"),
        ("##NPOINTS= 1e18", data, "NPOINTS is 1000000000000000000"),
        ("##DELTAX= 10\n##YUNITS= ABSORBANCE", data, "no reflectance"),
        ("##DELTAX= 10\n##XUNITS= SECONDS", data, "XUNITS is 'SECONDS'"),
        ("##DELTAX= x", data, "DELTAX is 'x', not a number"),
        ("", data, "neither LASTX nor DELTAX"),
        (head, "", "without XYDATA"),
    ] {
        let message = refusal(&jdx(more, data));
        assert!(message.contains(part), "{data}: {message}");
    }
}

/// A few lines of any file altered at random: read or refused in a sentence, never worse.
#[test]
fn mutated_files_are_read_or_refused_but_never_more() {
    let seeds = [
        "wl;a;b\n400;8,5;9\n450;10,2;9,9\n500;12;15,5\n700;30;32\n".to_owned(),
        "\"\",\"wl\",\"s\"\n\"1\",400,0.1\n\"2\",450,0.2\n\"3\",500,0.3\n".to_owned(),
        "Jaz Data File\n>>>>>Begin Processed Spectral Data<<<<<\nW\tD\tR\tS\tP\n400\t1\t2\t3\t4\n500\t1\t2\t3\t5\n>>>>>End\n".to_owned(),
        jdx("##FIRSTX= 400\n##LASTX= 460\n##NPOINTS= 7", "##XYDATA=(X++(Y..Y))\n400A0JT%T\n440A2jk\n460I"),
        jdx("##DELTAX= 10", "##XYDATA=(X++(Y..Y))\n400 10 11 12"),
        "wl,id,R\n400,s0,0.1\n500,s0,0.3\n400,s1,0.2\n500,s1,0.4\n".to_owned(),
    ];
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    let mut next = |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state % below as u64) as usize
    };
    let pieces: [&[u8]; 24] = [
        b",",
        b";",
        b"\t",
        b"\n",
        b"\r",
        b"\"",
        b"-",
        b"e",
        b"E99",
        b"%",
        b"##",
        b"=",
        b"s9",
        b"@",
        b"NaN",
        b"inf",
        b"999999999999",
        b"0",
        b".",
        b" ",
        b"\xff",
        b"\xc2",
        b"$$",
        b">>>>>Begin",
    ];
    let (mut read, mut refused) = (0, 0);
    for round in 0..10_000 {
        let mut bytes = seeds[round % seeds.len()].clone().into_bytes();
        for _ in 0..=next(4) {
            let at = next(bytes.len() + 1);
            match next(4) {
                0 if at < bytes.len() => bytes[at] = next(256) as u8,
                1 => {
                    let end = (at + next(12)).min(bytes.len());
                    bytes.drain(at..end);
                }
                2 => {
                    let end = (at + next(30)).min(bytes.len());
                    let again = bytes[at..end].to_vec();
                    bytes.splice(at..at, again);
                }
                _ => {
                    bytes.splice(at..at, pieces[next(pieces.len())].iter().copied());
                }
            }
        }
        let column = [None, Some("a"), Some("2"), Some("swallow")][next(4)];
        match parse_measured("m", &bytes, column, None) {
            Ok(measured) => {
                read += 1;
                assert!(measured.mean.values().iter().all(|v| v.is_finite() && v.abs() < 1001.0));
                assert!(measured.reading.chars().count() < 600 && !measured.reading.contains('\n'));
            }
            Err(error) => {
                refused += 1;
                let message = error.to_string();
                assert!(error.is_input() && message.chars().count() < 600, "{message}");
                assert!(!message.contains('\n') && !message.contains('\u{1b}'), "{message:?}");
            }
        }
    }
    assert!(read > 1000 && refused > 1000, "{read} read, {refused} refused");
}

#[test]
fn huge_files_are_refused_before_they_are_kept() {
    let wide = format!("wl{}\n400{}\n", ",a".repeat(1_000_000), ",1".repeat(1_000_000));
    assert!(refusal(&wide).contains("over the limit"));
    let header = format!("wl{}\n400,1\n500,1\n", ",a".repeat(1_000_000));
    assert!(refusal(&header).contains("names 1000001 columns"));
    let long: String = "400,1\n".repeat(200_001);
    assert!(refusal(&long).contains("over 200000 lines"));
    let quoted = "\"".repeat(1_000_000);
    assert!(refusal(&quoted).contains("no lines of numbers"));
}
