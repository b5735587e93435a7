//! Outputs that are there already, are no files, or fail.

use super::*;
use crate::io::read_text;

fn message<T>(result: Result<T>) -> String {
    result.err().map(|e| e.to_string()).unwrap_or_default()
}

fn entries(folder: &Path) -> usize {
    fs::read_dir(folder).unwrap().count()
}

#[test]
fn a_file_is_written_whole_and_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.txt");
    write_whole(&path, b"one").unwrap();
    write_whole(&path, b"two").unwrap();
    assert_eq!(read_text(&path).unwrap(), "two");
    assert_eq!(entries(folder.path()), 1);
}

#[test]
fn names_that_no_file_can_have_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    for (path, part) in [
        (PathBuf::new(), "needs a name"),
        (PathBuf::from("-"), "give one, or /dev/stdout"),
        (folder.path().to_owned(), "is a folder; give a file name"),
        (at("no/where"), "does not exist"),
        (at("new/"), "give a file name"),
        (at(&"x".repeat(300)), "cannot be written"),
    ] {
        for text in [message(check_writable(&path)), message(write_whole(&path, b"x"))] {
            assert!(text.contains(part), "{}: {text}", path.display());
        }
    }
    assert_eq!(entries(folder.path()), 0);
}

#[test]
fn files_inside_a_campaign_store_are_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let store = folder.path().join("s.zarr");
    fs::create_dir_all(store.join("u")).unwrap();
    fs::write(store.join("zarr.json"), r#"{"attributes": {"barbule_store": 4}}"#).unwrap();
    for name in ["zarr.json", "new.svg", "u/new.svg"] {
        assert!(message(check_writable(&store.join(name))).contains("inside a campaign store"), "{name}");
    }
    check_writable(&folder.path().join("s.svg")).unwrap();
    // Another's group of arrays may hold what it likes.
    fs::write(store.join("zarr.json"), r#"{"attributes": {}}"#).unwrap();
    check_writable(&store.join("new.svg")).unwrap();
}

#[test]
fn files_that_appear_together_appear_all_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    let [old, new, folder_name] = ["old", "new", "folder"].map(|name| folder.path().join(name));
    fs::write(&old, "before").unwrap();
    let files: [(&Path, &[u8]); 3] = [(&old, b"1"), (&new, b"2"), (&folder_name, b"3")];
    // The third cannot be renamed: a folder takes its place after all were written aside.
    let mut outputs: Vec<_> =
        files.iter().map(|(path, bytes)| Output::prepared(path, bytes).unwrap()).collect();
    fs::create_dir(&folder_name).unwrap();
    outputs[0].appear(true).unwrap();
    outputs[1].appear(true).unwrap();
    assert_eq!((read_text(&old).unwrap(), read_text(&new).unwrap()), ("1".into(), "2".into()));
    assert!(outputs[2].appear(true).is_err());
    outputs[..2].iter_mut().for_each(Output::vanish);
    drop(outputs);
    assert_eq!(read_text(&old).unwrap(), "before");
    assert!(!new.exists());
    assert_eq!(entries(folder.path()), 2);
    // As the program sees it.
    assert!(message(write_together(&files)).contains("is a folder"));
    assert_eq!((read_text(&old).unwrap(), new.exists()), ("before".into(), false));
    write_together(&files[..2]).unwrap();
    assert_eq!((read_text(&old).unwrap(), read_text(&new).unwrap()), ("1".into(), "2".into()));
    assert_eq!(entries(folder.path()), 3);
}

#[test]
fn what_killed_runs_leave_is_deleted_and_what_others_write_or_own_is_not() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a");
    let name = |name: &str| folder.path().join(name);
    fs::write(name(".barbule-deadbeefdead.part"), "half").unwrap();
    fs::write(name(".barbule-notes"), "mine").unwrap();
    fs::write(name("x.part"), "mine").unwrap();
    let busy = temporary_beside(&path).unwrap();
    write_whole(&path, b"x").unwrap();
    assert!(busy.path().exists() && name(".barbule-notes").exists() && name("x.part").exists());
    assert!(!name(".barbule-deadbeefdead.part").exists());
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| (0..50).for_each(|_| write_whole(&path, b"whole").unwrap()));
        }
    });
    assert_eq!(read_text(&path).unwrap(), "whole");
    drop(busy);
    assert_eq!(entries(folder.path()), 3);
}

#[cfg(unix)]
mod unix {
    use std::os::unix::fs::{PermissionsExt as _, symlink};
    use std::process::Command;

    use super::*;

    fn mode(path: &Path) -> u32 {
        fs::metadata(path).unwrap().permissions().mode() & 0o7777
    }

    #[test]
    fn permissions_stay_and_a_write_protected_file_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        fs::write(&path, "before").unwrap();
        for kept in [0o600, 0o640, 0o755] {
            fs::set_permissions(&path, fs::Permissions::from_mode(kept)).unwrap();
            write_whole(&path, b"x").unwrap();
            assert_eq!(mode(&path), kept);
        }
        fs::set_permissions(&path, fs::Permissions::from_mode(0o444)).unwrap();
        assert!(message(check_writable(&path)).contains("is write-protected"));
        assert!(message(write_whole(&path, b"y")).contains("is write-protected"));
        assert_eq!((read_text(&path).unwrap(), mode(&path)), ("x".into(), 0o444));
    }

    #[test]
    fn links_stay_and_what_they_lead_to_is_replaced_or_made() {
        let folder = tempfile::tempdir().unwrap();
        let name = |name: &str| folder.path().join(name);
        fs::create_dir(name("elsewhere")).unwrap();
        fs::write(name("elsewhere/real"), "before").unwrap();
        symlink("elsewhere/real", name("one")).unwrap();
        symlink("one", name("two")).unwrap();
        symlink("elsewhere/new", name("dangling")).unwrap();
        symlink("no/where", name("broken")).unwrap();
        symlink("circle", name("circle")).unwrap();
        write_whole(&name("two"), b"after").unwrap();
        write_whole(&name("dangling"), b"made").unwrap();
        for link in ["one", "two", "dangling"] {
            assert!(fs::symlink_metadata(name(link)).unwrap().is_symlink(), "{link}");
        }
        assert_eq!(read_text(&name("elsewhere/real")).unwrap(), "after");
        assert_eq!(read_text(&name("elsewhere/new")).unwrap(), "made");
        assert!(message(write_whole(&name("broken"), b"")).contains("does not exist"));
        assert!(message(write_whole(&name("circle"), b"")).contains("circle of links"));
    }

    #[test]
    fn pipes_and_devices_are_written_through_and_never_replaced() {
        use std::os::unix::fs::FileTypeExt as _;
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let reader = {
            let pipe = pipe.clone();
            std::thread::spawn(move || fs::read_to_string(pipe).unwrap())
        };
        write_whole(&pipe, b"through").unwrap();
        assert_eq!(reader.join().unwrap(), "through");
        assert!(fs::symlink_metadata(&pipe).unwrap().file_type().is_fifo());
        write_whole(Path::new("/dev/null"), b"gone").unwrap();
        assert!(fs::metadata("/dev/null").unwrap().file_type().is_char_device());
        symlink("/dev/null", folder.path().join("null")).unwrap();
        write_whole(&folder.path().join("null"), b"gone").unwrap();
        assert_eq!(entries(folder.path()), 2);
        let socket = folder.path().join("socket");
        let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
        assert!(message(check_writable(&socket)).contains("is no file"));
        #[cfg(target_os = "linux")]
        {
            let full = write_whole(Path::new("/dev/full"), b"x").unwrap_err();
            assert!(!full.is_input() && full.to_string().contains("free some space"), "{full}");
        }
    }

    #[test]
    fn a_file_is_the_same_under_every_name() {
        let folder = tempfile::tempdir().unwrap();
        let name = |name: &str| folder.path().join(name);
        fs::create_dir(name("sub")).unwrap();
        fs::write(name("a"), "").unwrap();
        fs::hard_link(name("a"), name("hard")).unwrap();
        symlink("a", name("soft")).unwrap();
        symlink("new", name("to-new")).unwrap();
        for same in ["a", "sub/../a", "hard", "soft"] {
            assert!(is_same_file(&name("a"), &name(same)), "{same}");
        }
        for same in ["new", "./new", "sub/../new", "to-new"] {
            assert!(is_same_file(&name("new"), &name(same)), "{same}");
        }
        assert!(!is_same_file(&name("a"), &name("new")) && !is_same_file(&name("new"), &name("newer")));
    }
}
