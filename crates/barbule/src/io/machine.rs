//! What the machine has left, where it says so.

use std::fs;

/// Bytes of memory that this process may still take: what the system calls available, and what the limits of its control
/// group and of its address space leave. `None` where nothing of this is known, as on systems other than Linux.
#[must_use]
pub fn available_memory() -> Option<u64> {
    let text = |path: &str| fs::read_to_string(path).ok();
    let system = text("/proc/meminfo").and_then(|text| kilobytes(&text, "MemAvailable:"));
    let group = || {
        let number = |path: &str| text(path)?.trim().parse::<u64>().ok();
        let limit = number("/sys/fs/cgroup/memory.max")?;
        Some(limit.saturating_sub(number("/sys/fs/cgroup/memory.current")?))
    };
    let space = || {
        let limit = address_space(&text("/proc/self/limits")?)?;
        let taken = kilobytes(&text("/proc/self/status")?, "VmSize:")?;
        Some(limit.saturating_sub(taken))
    };
    [system, group(), space()].into_iter().flatten().min()
}

/// The most bytes of memory that this process has held at once; `None` on systems other than Linux.
#[must_use]
pub fn peak_memory() -> Option<u64> {
    kilobytes(&fs::read_to_string("/proc/self/status").ok()?, "VmHWM:")
}

/// `KEY  123 kB` in bytes.
fn kilobytes(text: &str, key: &str) -> Option<u64> {
    let rest = text.lines().find_map(|line| line.strip_prefix(key))?;
    rest.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

/// The soft limit of the address space; `None`: unlimited.
fn address_space(text: &str) -> Option<u64> {
    let rest = text.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    rest.split_whitespace().next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_files_of_linux_are_read() {
        let text = "MemTotal:       24012345 kB\nMemAvailable:   20000000 kB\n";
        assert_eq!(kilobytes(text, "MemAvailable:"), Some(20_480_000_000));
        assert_eq!(kilobytes(text, "SwapFree:"), None);
        let limits = "Limit                     Soft Limit           Hard Limit           Units     \n\
                      Max address space         4294967296           unlimited            bytes     \n";
        assert_eq!(address_space(limits), Some(4 << 30));
        assert_eq!(address_space(&limits.replace("4294967296", "unlimited ")), None);
        if cfg!(target_os = "linux") {
            assert!(available_memory().unwrap() > 10_000_000);
            let block = vec![1_u8; 64 << 20];
            assert!(peak_memory().unwrap() > block.len() as u64);
        }
    }
}
