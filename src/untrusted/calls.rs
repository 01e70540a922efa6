//! The calls of the kernel that confined work may make. All others fail, as if the kernel did not have them: so the C
//! library takes the older way where it knows one, and nothing ends where it only asks.

use seccompiler::{
    BackendError, SeccompAction, SeccompCmpArgLen as Length, SeccompCmpOp as Is, SeccompCondition,
    SeccompFilter, SeccompRule,
};
use std::collections::BTreeMap;

/// Calls with any arguments: they work on memory, on files that are open or that Landlock lets be opened, and on
/// threads of this process.
const FREE: &[i64] = &[
    // Memory.
    libc::SYS_brk,
    libc::SYS_mmap,
    libc::SYS_munmap,
    libc::SYS_mprotect,
    libc::SYS_mremap,
    libc::SYS_madvise,
    // Files.
    libc::SYS_openat,
    libc::SYS_close,
    libc::SYS_read,
    libc::SYS_write,
    libc::SYS_readv,
    libc::SYS_writev,
    libc::SYS_pread64,
    libc::SYS_pwrite64,
    libc::SYS_lseek,
    libc::SYS_fstat,
    libc::SYS_newfstatat,
    libc::SYS_statx,
    libc::SYS_readlinkat,
    libc::SYS_faccessat,
    libc::SYS_getdents64,
    libc::SYS_getcwd,
    libc::SYS_fcntl,
    libc::SYS_flock,
    libc::SYS_fsync,
    libc::SYS_fdatasync,
    libc::SYS_ftruncate,
    libc::SYS_fchmod,
    libc::SYS_mkdirat,
    libc::SYS_renameat,
    libc::SYS_renameat2,
    libc::SYS_unlinkat,
    libc::SYS_dup,
    libc::SYS_pipe2,
    libc::SYS_ppoll,
    // Threads and time.
    libc::SYS_futex,
    libc::SYS_set_robust_list,
    libc::SYS_rseq,
    libc::SYS_sched_yield,
    libc::SYS_sched_getaffinity,
    libc::SYS_clock_gettime,
    libc::SYS_clock_getres,
    libc::SYS_clock_nanosleep,
    libc::SYS_nanosleep,
    libc::SYS_gettimeofday,
    libc::SYS_getrusage,
    libc::SYS_restart_syscall,
    libc::SYS_membarrier,
    // This process: who it is, its signals, its end.
    libc::SYS_getpid,
    libc::SYS_gettid,
    libc::SYS_getuid,
    libc::SYS_geteuid,
    libc::SYS_getgid,
    libc::SYS_getegid,
    libc::SYS_getrandom,
    libc::SYS_sysinfo,
    libc::SYS_uname,
    libc::SYS_rt_sigaction,
    libc::SYS_rt_sigprocmask,
    libc::SYS_rt_sigreturn,
    libc::SYS_sigaltstack,
    libc::SYS_exit,
    libc::SYS_exit_group,
];

/// The same under their older names, which some kernels have besides.
#[cfg(target_arch = "x86_64")]
const OLDER: &[i64] = &[
    libc::SYS_open,
    libc::SYS_stat,
    libc::SYS_lstat,
    libc::SYS_access,
    libc::SYS_readlink,
    libc::SYS_mkdir,
    libc::SYS_rename,
    libc::SYS_unlink,
    libc::SYS_rmdir,
    libc::SYS_poll,
    libc::SYS_time,
];
#[cfg(not(target_arch = "x86_64"))]
const OLDER: &[i64] = &[];

/// Requests of `ioctl`: what a terminal is like, and flags of open files. Others would type into the terminal.
const REQUESTS: [u64; 4] = [
    libc::TCGETS,
    libc::TIOCGWINSZ,
    libc::FIOCLEX,
    libc::FIONREAD,
];

/// Options of `prctl`: names of threads and of memory.
const OPTIONS: [u64; 2] = [libc::PR_SET_NAME as u64, libc::PR_SET_VMA as u64];

/// A condition on one argument of a call.
fn rule(argument: u8, length: Length, is: Is, value: u64) -> Result<SeccompRule, BackendError> {
    SeccompRule::new(vec![SeccompCondition::new(argument, length, is, value)?])
}

/// The filter for the process of this number.
pub(super) fn filter(process: u32) -> Result<SeccompFilter, BackendError> {
    let any = FREE.iter().chain(OLDER).map(|&call| (call, Vec::new()));
    let mut rules: BTreeMap<i64, Vec<SeccompRule>> = any.collect();
    let each = |values: &[u64], argument| -> Result<Vec<SeccompRule>, BackendError> {
        values
            .iter()
            .map(|&value| rule(argument, Length::Dword, Is::Eq, value))
            .collect()
    };
    rules.insert(libc::SYS_ioctl, each(&REQUESTS, 1)?);
    rules.insert(libc::SYS_prctl, each(&OPTIONS, 0)?);
    // A signal to itself is how a process aborts.
    rules.insert(libc::SYS_tgkill, each(&[u64::from(process)], 0)?);
    // Limits are read, not set: the superuser could raise them.
    let reads = rule(2, Length::Qword, Is::Eq, 0)?;
    rules.insert(libc::SYS_prlimit64, vec![reads]);
    // A thread, not another process. Arguments of `clone3` are behind a pointer, so there is none of that.
    let thread = libc::CLONE_THREAD as u64;
    let spawns = rule(0, Length::Dword, Is::MaskedEq(thread), thread)?;
    rules.insert(libc::SYS_clone, vec![spawns]);
    let otherwise = SeccompAction::Errno(libc::ENOSYS as u32);
    let architecture = std::env::consts::ARCH.try_into()?;
    SeccompFilter::new(rules, otherwise, SeccompAction::Allow, architecture)
}
