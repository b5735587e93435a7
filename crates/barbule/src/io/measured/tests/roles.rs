//! Which columns are wavelengths, samples and neither; percent of each; long tables.

use super::*;

fn said(text: &str, part: &str) -> Measured {
    let found = read(text);
    assert!(found.reading.contains(part), "{text:?}: {}", found.reading);
    found
}

fn refused(text: &str, part: &str) {
    let message = refusal(text);
    assert!(message.contains(part), "{text:?}: {message}");
}

#[test]
fn every_sample_is_read_on_its_own_wavelengths() {
    let values =
        [("400", "0.1", "420", "0.26"), ("450", "0.2", "460", "0.30"), ("500", "0.3", "500", "0.34")];
    let table = |names: &str| {
        let lines = values.map(|(a, b, c, d)| format!("{a},{b},{c},{d}"));
        format!("{names}\n{}\n", lines.join("\n"))
    };
    for names in [
        "wl1,R1,wl2,R2",
        "wl,b1,wl.1,b2",
        "Wavelength,back,Wavelength2,belly",
        "Wavelength (nm),back,Wavelength (nm).1,belly",
        "nm,a bird,nm_2,another",
        "x,y,x,y",
        "X,Y,X.1,Y.1",
        "wl,b1,other,b2",
    ] {
        let found = said(&table(names), "samples at wavelengths of their own, brought to those of the first");
        // 400 nm lies outside the second's.
        assert_eq!(found.mean.wavelengths().nm(), [450.0, 500.0], "{names}");
        let close = |value: f64, expected: f64| (value - expected).abs() < 1e-12;
        assert!(close(found.samples[1].spectrum.values()[0], 0.29), "{names}: {found:?}");
        assert_eq!(found.samples[1].spectrum.values()[1], 0.34);
        assert_eq!(found.samples[0].spectrum.values(), [0.2, 0.3]);
        // One of them alone keeps its own.
        let one = of(&table(names), "4").unwrap();
        assert_eq!(
            (one.mean.wavelengths().nm(), one.mean.values()),
            (&[420.0, 460.0, 500.0][..], &[0.26, 0.3, 0.34][..])
        );
        assert!(of(&table(names), "3").unwrap_err().to_string().contains("is the wavelength"));
    }
    // The same wavelengths again are the same, and a shorter second half ends in empty cells.
    assert_eq!(read("wl,a,wl2,b\n400,0.1,400,0.3\n500,0.3,500,0.5\n").mean.values(), [0.2, 0.4]);
    let shorter = read("wl,a,wl2,b\n400,0.1,400,0.3\n450,0.1,500,0.5\n500,0.3,,\n");
    assert_eq!(shorter.mean.wavelengths().nm(), [400.0, 450.0, 500.0]);
    for text in ["wl1,wl2,R\n400,410,0.1\n500,510,0.3\n", "R1,wl1,R2,wl2\n0.1,400,0.2,410\n0.1,500,0.2,510\n"]
    {
        refused(text, "are both wavelengths, and differ; keep one, put each before its own samples");
    }
}

#[test]
fn what_is_still_no_reflectance_after_the_scale_is_refused_by_name() {
    refused(
        "wl,bird,temperature of light\n400,10,410\n500,30,400\n600,20,500\n",
        "'temperature of light' still reaches 5 after",
    );
    // Gloss beside a white that scatters is over 100 %: who says the unit is believed.
    let gloss = "wl,R%\n400,500\n500,700\n";
    assert_eq!(read(gloss).mean.values(), [5.0, 7.0]);
    refused(
        &gloss.replace('%', ""),
        "'R' still reaches 7 after the division by 100, which is no reflectance",
    );
    let given =
        parse_measured("m.csv", gloss.replace('%', "").as_bytes(), None, Some(Scale::Percent)).unwrap();
    assert_eq!(given.mean.values(), [5.0, 7.0]);
}

#[test]
fn columns_that_are_no_samples_are_left_out_or_refused() {
    for (column, part) in [
        ("N", "'N' left out"),
        ("n", "'n' left out"),
        ("age", "'age' left out"),
        ("id", "'id' left out"),
        ("No", "'No' left out"),
        ("lower", "'lower' left out"),
        ("upper 95%", "'upper 95%' left out"),
        ("mean_lower", "'mean_lower' left out"),
        ("ci", "'ci' left out"),
        ("sd2", "'sd2' left out"),
        ("mean", "'mean' left out"),
        ("Mittelwert", "'Mittelwert' left out"),
        ("mean reflectance", "'mean reflectance' left out"),
        ("clutch", "'clutch' left out, the same number in every line"),
    ] {
        let found = said(&format!("wl,bird1,{column}\n400,0.1,12\n500,0.3,12\n600,0.2,12\n"), part);
        assert_eq!((names(&found), found.mean.values()), (vec!["bird1"], &[0.1, 0.3, 0.2][..]), "{column}");
    }
    for column in [
        "white_ref",
        "ref",
        "dark 2",
        "reference",
        "count",
        "T",
        "%T",
        "T%",
        "Trans",
        "Abs",
        "Absorbance (a.u.)",
    ] {
        refused(
            &format!("wl,{column},bird\n400,99,10\n500,99,30\n600,98,20\n"),
            &format!(
                "columns '{column}', 'bird' are not all reflectances by their names; name one with `column`"
            ),
        );
    }
    for column in [
        "%T",
        "T",
        "t",
        "T%",
        "T (%)",
        "Trans",
        "A",
        "a",
        "Abs",
        "Abs.",
        "transmittance",
        "log(1/R)",
        "Extinktion",
    ] {
        let text = format!("wl,{column}\n400,0.1\n500,0.3\n");
        refused(&text, &format!("column '{column}' is no reflectance by its name; name one with `column`"));
        assert_eq!(of(&text, column).unwrap().samples.len(), 1);
    }
    // Letters of birds, a treatment, patches.
    for (columns, count) in
        [("A,B", 2), ("T,C", 2), ("a,T2", 2), ("lower back,upper back", 2), ("white throat,n1", 2)]
    {
        assert_eq!(
            read(&format!("wl,{columns}\n400,0.1,0.2\n500,0.3,0.2\n")).samples.len(),
            count,
            "{columns}"
        );
    }
    assert_eq!(names(&read("wl,R,T,A\n400,0.1,0.2,0.7\n500,0.3,0.2,0.5\n")), ["R"]);
    let band = read("wl,mean,2.5%,97.5%,low,high\n400,0.1,0,1,0,1\n500,0.3,0,1,0,1\n");
    assert_eq!((names(&band), band.mean.values()), (vec!["mean"], &[0.1, 0.3][..]));
    for unit in ["%T", "T", "A", "ABS", "TRANS."] {
        let text = jdx("##DELTAX= 10", "##XYDATA=(X++(Y..Y))\n400 10 11 12");
        refused(&text.replace("REFLECTANCE", unit), "which is no reflectance; export reflectance");
    }
}

#[test]
fn spelled_out_spreads_beside_means_are_left_out() {
    for spread in [
        "Standard Deviation",
        "St. Dev.",
        "Standard deviation (%)",
        "Deviation",
        "Range",
        "N samples",
        "Standardabweichung",
        "écart type",
        "ecart type",
        "Desviación estándar",
        "SD (n=5)",
    ] {
        let text =
            format!("Wavelength,Mean Reflectance,{spread}\n400,0.1,0.01\n500,0.3,0.02\n600,0.2,0.03\n");
        let found = said(&text, &format!("'{spread}' left out"));
        assert_eq!(
            (names(&found), found.mean.values()),
            (vec!["Mean Reflectance"], &[0.1, 0.3, 0.2][..]),
            "{spread}"
        );
        assert!(found.reading.contains("1 sample, 'Mean Reflectance'"), "{}", found.reading);
    }
    for (one, other, spreads) in [
        ("Back Mean", "Belly Mean", ["Back Standard Deviation", "Belly Standard Deviation"]),
        ("male mean", "throat mean", ["male SD (n=5)", "throat Standard Deviation"]),
    ] {
        let [a, b] = spreads;
        let text = format!("wl,{one},{a},{other},{b}\n400,0.1,0.01,0.2,0.02\n500,0.3,0.02,0.4,0.01\n");
        let found = said(&text, &format!("2 samples, '{one}' and '{other}'; values to 0.4"));
        assert!(found.reading.contains(&format!("'{a}', '{b}' left out")), "{}", found.reading);
        assert_eq!(names(&found), [one, other]);
    }
    let birds = read(
        "wl,range finch,orange,St Kilda wren,grouse (home range)\n400,0.1,0.2,0.1,0.2\n500,0.3,0.2,0.1,0.2\n",
    );
    assert_eq!(birds.samples.len(), 4);
    let long =
        "wl,bird,Mean,Standard Deviation\n400,x,0.1,0.01\n500,x,0.3,0.02\n400,y,0.2,0.01\n500,y,0.4,0.02\n";
    let found = said(long, "'Standard Deviation' left out");
    assert_eq!((names(&found), found.samples[1].spectrum.values()), (vec!["x", "y"], &[0.2, 0.4][..]));
    refused(
        &long.replace("Standard Deviation", "Chroma"),
        "columns 'Mean', 'Chroma' that could all be reflectance",
    );
}

#[test]
fn a_mean_is_left_out_where_it_is_that_of_the_samples_beside_it() {
    for (text, kept) in [
        ("wl,a,b,mean\n400,0.1,0.2,0.15\n500,0.3,0.5,0.4\n", vec!["a", "b"]),
        // As rounded as tables are.
        ("wl,Average,a,b\n400,0.15,0.101,0.2\n500,0.4,0.301,0.5\n", vec!["a", "b"]),
        ("wl,a,b,c,median\n400,0.1,0.2,0.6,0.2\n500,0.3,0.4,0.8,0.4\n", vec!["a", "b", "c"]),
        ("wl,a,b,mean\n400,0.1,0.2,0.15\n450,NA,0.2,0.2\n500,0.3,0.5,0.4\n", vec!["a", "b"]),
        // The same numbers whichever is taken.
        ("wl,bird,mean\n400,0.1,0.1\n500,0.3,0.3\n", vec!["bird"]),
    ] {
        let found = read(text);
        assert_eq!(names(&found), kept, "{}", found.reading);
        assert!(found.reading.contains(" left out"), "{}", found.reading);
    }
    for (columns, listed, mean) in [
        ("Mean Reflectance,Chroma", "'Mean Reflectance', 'Chroma'", "'Mean Reflectance'"),
        ("a,b,mean", "'a', 'b', 'mean'", "'mean'"),
        ("Mittelwert,Back Mean,Belly Mean", "'Mittelwert', 'Back Mean', 'Belly Mean'", "'Mittelwert'"),
    ] {
        let cells = |values: [&str; 3]| values[..columns.split(',').count()].join(",");
        let text = format!(
            "wl,{columns}\n400,{}\n500,{}\n600,{}\n",
            cells(["0.1", "0.3", "0.5"]),
            cells(["0.3", "0.5", "0.2"]),
            cells(["0.2", "0.4", "0.3"])
        );
        refused(
            &text,
            &format!(
                "columns {listed} may all be reflectances, but {mean} is not the mean of the others; name one with `column`"
            ),
        );
        assert_eq!(of(&text, "2").unwrap().mean.values(), [0.1, 0.3, 0.2]);
    }
}

#[test]
fn percent_and_parts_of_1_are_told_for_each_column() {
    let found = said(
        "wl,R1,R2\n400,0.1,12\n500,0.3,28\n",
        "2 samples; 'R2' percent divided by 100, 'R1' taken as parts of 1",
    );
    assert_eq!(found.samples[0].spectrum.values(), [0.1, 0.3]);
    assert_eq!(found.samples[1].spectrum.values(), [0.12, 0.28]);
    assert_eq!(read("wl,R1,R2\n400,10%,0.12\n500,30%,0.28\n").samples[1].spectrum.values(), [0.12, 0.28]);
    assert_eq!(read("wl,%back,bird\n400,10,0.12\n500,30,0.28\n").samples[1].spectrum.values(), [0.12, 0.28]);
    // A black one in percent beside a white one, or parts of 1: nobody can tell.
    let black = "wl,a1,b1\n400,0.5,10\n500,0.9,16\n";
    refused(
        black,
        "'b1' may be percent (to 16) beside 'a1' in parts of 1 (to 0.9), or all percent; write % into",
    );
    assert_eq!(
        read(&black.replace("a1,b1", "a1%,b1%")).samples[0].spectrum.values(),
        [0.5 / 100.0, 0.9 / 100.0]
    );
    // Over 1 it would be no part of 1.
    assert_eq!(read("wl,a1,b1\n400,0.5,10\n500,1.3,20\n").samples[0].spectrum.values()[0], 0.5 / 100.0);
    // Depths beside birds, which nothing says but their size.
    refused(
        "wl,b1,depth_mm\n400,0.0005,3\n500,0.0015,4\n",
        "'b1' is 35 times lower than 'depth_mm' in the mean",
    );
}

#[test]
fn samples_that_are_far_apart_are_no_samples_of_one_kind() {
    refused(
        "wl,b1,b2,odd\n400,0.30,0.2,0.004\n500,0.30,0.2,0.006\n",
        "'odd' is 40 times lower than 'b2' in the mean, so that they are no samples of one kind; leave the column out, or name one",
    );
    assert_eq!(read("wl,crown,belly\n400,0.03,0.5\n500,0.03,0.55\n").samples.len(), 2);
    assert_eq!(read("wl,nothing,belly\n400,0,0.5\n500,0,0.55\n").samples.len(), 2);
}

#[test]
fn a_line_of_numbers_with_a_typing_error_is_no_line_of_names() {
    for (text, part) in [
        (
            "400,0.1O\n500,0.3\n600,0.2\n",
            "line 1, column 2: '0.1O' is not a finite number (are these names? name the wavelengths wl)",
        ),
        ("4OO,0.1\n500,0.3\n600,0.2\n", "line 1, column 1: '4OO' is not a finite number"),
        ("wl,R\n400,0.1O\n500,0.3\n600,0.2\n", "line 2, column 2: '0.1O'"),
        ("400,0.1x,0.2\n500,0.3,0.2\n600,0.2,0.2\n", "line 1, column 2: '0.1x'"),
        ("400,0.1,\n500,0.3\n600,0.2\n", "line 1: has 3 columns, but the lines of numbers below have 2"),
        ("400;0,1;x\n500;0,3;0,1\n600;0,3;0,1\n", "line 1, column 3: 'x'"),
    ] {
        refused(text, part);
    }
    // Comments, years as names of samples and units are names, or nothing.
    assert_eq!(read("# 390,0.1\n400,0.1\n500,0.3\n").mean.values().len(), 2);
    assert_eq!(names(&read("wl,2019,2020\n400,0.1,0.2\n500,0.3,0.2\n")), ["2019", "2020"]);
}

#[test]
fn row_numbers_of_pandas_are_left_out() {
    for text in [
        ",0,1\n0,400,0.1\n1,500,0.3\n",
        ",wl,R\n0,400,0.1\n1,500,0.3\n",
        ",wl,R\n3,400,0.1\n7,500,0.3\n",
        "Unnamed: 0,wl,R\n0,400,0.1\n1,500,0.3\n",
    ] {
        let found = said(text, "row numbers left out");
        assert_eq!(
            (found.mean.wavelengths().nm(), found.mean.values()),
            (&[400.0, 500.0][..], &[0.1, 0.3][..])
        );
    }
    // Wavelengths without a name are no row numbers.
    assert_eq!(read(",R\n400,0.1\n401,0.3\n").mean.values(), [0.1, 0.3]);
}

#[test]
fn absurd_wavelengths_are_refused_with_their_line() {
    let head = "##NPOINTS= 3";
    for (x, part) in [
        ("1e308", "line 8: 1e308 in ##XYDATA"),
        ("3e7", "in ##XYDATA is no wavelength of light, which has 1 to 1000000 nm"),
    ] {
        refused(&jdx(head, &format!("##XYPOINTS= (XY..XY)\n400 10 410 11 {x} 12")), part);
    }
    refused(&jdx("##XFACTOR= 1e300\n##NPOINTS= 1", "##XYPOINTS= (XY..XY)\n1e300 10"), "is not finite");
    refused("wl,R\n400,0.1\n500,0.2\n1e9,0.3\n", "line 4: 1e9 in 'wl' is no wavelength of light");
    refused("wavenumber,R\n20000,0.1\n1e-300,0.2\n", "is no wavelength of light");
}

#[test]
fn long_tables_are_read_by_the_names_of_their_samples() {
    let rows = [("400", "s0", "0.1"), ("500", "s0", "0.3"), ("400", "s 1", "0.2"), ("500", "s 1", "0.4")];
    let table = |names: &str, separator: &str, order: [usize; 4]| {
        let line = |i: usize| [rows[i].0, rows[i].1, rows[i].2].join(separator);
        format!("{}\n{}\n", names.replace(',', separator), order.map(line).join("\n"))
    };
    let plain = read("wl,s0,s 1\n400,0.1,0.2\n500,0.3,0.4\n");
    for text in [
        table("wl,sample,R", ",", [0, 1, 2, 3]),
        table("wl,sample,R", ",", [0, 2, 1, 3]),
        table("wl,sample,R", ",", [1, 0, 2, 3]),
        table("wavelength_nm,who,reflectance", "\t", [0, 1, 2, 3]),
        table("nm;variable;value", ";", [0, 1, 2, 3]).replace('.', ","),
        "\"\",\"wl\",\"sample\",\"R\"\n\"1\",400,\"s0\",0.1\n\"2\",500,\"s0\",0.3\n\"3\",400,\"s 1\",0.2\n\"4\",500,\"s 1\",0.4\n".into(),
        "sample,bird_species,wl,R,sd,n\ns0,magpie,400,10%,1,3\ns0,magpie,500,30%,1,3\ns 1,magpie,400,20%,1,3\ns 1,magpie,500,40%,1,3\n".into(),
        "wl,sample,%R\n400,s0,10\n500,s0,30\n400,s 1,20\n500,s 1,40\n".into(),
    ] {
        let found = said(&text, "a line for each wavelength and sample, told apart by '");
        assert_eq!(names(&found), ["s0", "s 1"], "{text}");
        assert_eq!((&found.mean, &found.std), (&plain.mean, &plain.std), "{text}");
        for one in ["S 1", "2"] {
            let one = of(&text, one).unwrap();
            assert_eq!((names(&one), one.mean.values()), (vec!["s 1"], &[0.2, 0.4][..]));
        }
        let message = of(&text, "s7").unwrap_err().to_string();
        assert!(message.contains("there is no such sample, did you mean 's0'?; there are 2 samples: 's0', 's 1'"), "{message}");
    }
    let numbered = said(
        "wl,id,rep,R\n400,1,1,0.1\n500,1,1,0.3\n400,1,2,0.2\n500,1,2,0.4\n400,2,1,0.2\n500,2,1,0.4\n",
        "told apart by 'id', 'rep'",
    );
    assert_eq!(names(&numbered), ["1 1", "1 2", "2 1"]);
    let own = said(
        "wl,sample,R\n400,a,0.1\n450,a,0.2\n500,a,0.3\n420,b,0.26\n460,b,0.3\n500,b,0.34\n",
        "brought to those of the first",
    );
    assert_eq!(own.mean.wavelengths().nm(), [450.0, 500.0]);
    let gap = said(
        "wl,sample,R\n400,a,0.1\n500,a,NA\n600,a,0.1\n400,b,0.1\n500,b,0.1\n600,b,0.1\n",
        "1 line with missing values",
    );
    assert_eq!(gap.mean.wavelengths().nm(), [400.0, 600.0]);
}

#[test]
fn spoilt_long_tables_are_refused_where_they_are_spoilt() {
    let plain = "wl,sample,R\n400,s0,0.1\n500,s0,0.3\n400,s1,0.2\n500,s1,0.4\n";
    for (from, to, part) in [
        ("500,s1,0.4", "500,s1,0.4x", "line 5, column 3: '0.4x' is not a finite number"),
        ("500,s1,0.4", "5OO,s1,0.4", "line 5, column 1: '5OO' is not a finite number"),
        ("500,s1,0.4", "500,s1,0.4,1", "line 5: has 4 columns, but 3 are named"),
        ("400,s1", "400,s0", "line 4: the sample 's0' has the wavelength 400 again, as in line 2; tell"),
        ("sample,R", "sample,T", "but no column of reflectance by its name (there is 'T'); call it R"),
    ] {
        refused(&plain.replace(from, to), part);
    }
    let two = "wl,sample,a1,b1\n400,s0,0.1,1\n500,s0,0.3,1\n400,s1,0.2,1\n500,s1,0.4,1\n";
    refused(two, "and columns 'a1', 'b1' that could all be reflectance; call the one R");
    refused(
        "wl,R,remark\n400,0.1,ok\n500,0.3,noisy\n",
        "but no wavelength has two of them; leave that column out if it holds remarks",
    );
    assert_eq!(read("wl,R,remark\n400,0.1,ok\n500,0.3,ok\n").mean.values(), [0.1, 0.3]);
}
