//! The process that decodes one file for another process: reads the request, confines itself, and sends the frame back.
//!
//! A decoder that a crafted file has taken over can do what its process may do. So before the file is read the process
//! gives up the rest ([`confine`]): reading any other file, changing any, the network, other programs and processes.

use super::wire::{DecodeRequest, Part, receive, send_reply};
use crate::burst::reading::{Expected, RawFrame, Reading, Ticker};
use crate::error::{Error, Result};
use crate::{burst::options::OpenOptions, monitor::Monitor};
use std::io::{self, Read, Write};
use std::path::Path;

pub fn serve_decoding(path: &Path, decode: fn(Reading<'_>, Part) -> Result<RawFrame>) -> u8 {
    // A panic becomes an error about the file, which is sent; its message is dropped.
    std::panic::set_hook(Box::new(|_| {}));
    // 1: there was no request, or the answer could not be sent.
    u8::from(serve(path, decode).is_err())
}

fn serve(path: &Path, decode: fn(Reading<'_>, Part) -> Result<RawFrame>) -> io::Result<()> {
    let request: DecodeRequest = receive(&mut io::stdin().lock())?;
    // Before the file is opened: the request alone comes from a trusted process.
    limit(request.memory_bytes, request.cpu_seconds);
    confine(path);
    // Decoders that work in parallel use this thread alone; others would take address space of their own.
    let _ = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global();
    std::thread::Builder::new().stack_size(64 << 10).spawn(|| {
        // Input ends when the requesting process is gone: this one then ends too.
        let _ = io::stdin().lock().read(&mut [0]);
        std::process::exit(1);
    })?;
    let mut output = io::stdout().lock();
    send_reply(&mut output, answer(path, &request, decode))?;
    output.flush()
}

fn answer(path: &Path, request: &DecodeRequest, decode: fn(Reading<'_>, Part) -> Result<RawFrame>) -> Result<RawFrame> {
    if request.version != env!("CARGO_PKG_VERSION") {
        return Err(Error::unread(path, "the program was replaced while it ran; start it again"));
    }
    let options = OpenOptions { limits: request.limits, ..request.options.clone() };
    let expected = request.expected.as_ref().map(|(first, size)| Expected { first: Path::new(first), size: *size });
    let quiet = Monitor::default();
    decode(Reading { path, expected, options: &options, ticker: &Ticker::new(&quiet, 1) }, request.part)
}

/// Limits this process: memory that it may address (bytes), processor time (seconds), and no file may grow.
#[cfg(unix)]
fn limit(memory_bytes: u64, cpu_seconds: u64) {
    use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
    // The soft limit of time sends a signal that names the cause; the hard limit kills.
    let limits = [
        (Resource::As, memory_bytes, memory_bytes),
        (Resource::Cpu, cpu_seconds, cpu_seconds.saturating_add(5)),
        (Resource::Core, 0, 0),
        (Resource::Fsize, 0, 0),
    ];
    for (resource, current, maximum) in limits {
        let now = getrlimit(resource);
        let lower = |limit: Option<u64>, to: u64| Some(limit.map_or(to, |limit| limit.min(to)));
        let lowered = Rlimit { current: lower(now.current, current), maximum: lower(now.maximum, maximum) };
        // Where the system has no such limit, the parent's wall-clock limit remains.
        let _ = setrlimit(resource, lowered);
    }
}

#[cfg(not(unix))]
fn limit(_memory_bytes: u64, _cpu_seconds: u64) {}

/// Gives up what decoding `path` does not need, for this thread and those it starts, as far as the system offers it.
fn confine(path: &Path) {
    #[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
    let _ = (confined::to_file(path), confined::without_calls());
    #[cfg(not(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64"))))]
    let _ = path;
}

/// Rights that a thread can give up on Linux, without privileges and for ever.
#[cfg(all(target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
mod confined {
    use landlock::{
        ABI, Access, AccessFs, AccessNet, PathBeneath, PathFd, Ruleset, RulesetAttr, RulesetCreatedAttr, RulesetError,
        RulesetStatus, Scope,
    };
    use seccompiler::SeccompCmpArgLen::Dword;
    use seccompiler::SeccompCmpOp::{MaskedEq, Ne};
    use seccompiler::{
        BackendError, BpfProgram, SeccompAction, SeccompCondition, SeccompFilter, SeccompRule, TargetArch, apply_filter,
    };
    use std::{collections::BTreeMap, path::Path};

    /// Newest interface of Landlock whose rights are given up; an older kernel offers fewer of them.
    const NEWEST: ABI = ABI::V10;

    /// Gives up all files but reading `path`, TCP, signals and privileges; returns how much of this the kernel offers.
    pub fn to_file(path: &Path) -> Result<RulesetStatus, RulesetError> {
        let rules = Ruleset::default()
            .handle_access(AccessFs::from_all(NEWEST))?
            .handle_access(AccessNet::from_all(NEWEST))?
            .scope(Scope::from_all(NEWEST))?
            .create()?;
        let rules = match PathFd::new(path) {
            Ok(file) => rules.add_rule(PathBeneath::new(file, AccessFs::ReadFile))?,
            // Opening it will say why not.
            Err(_) => rules,
        };
        Ok(rules.restrict_self()?.ruleset)
    }

    macro_rules! calls {
        ($($call:ident)*) => { [$(libc::$call),*] };
    }

    /// System calls that decoding needs not and [`to_file`] leaves: the network, and programs that wait for orders at a
    /// socket; other programs and processes; priority, processors and memory, of other processes too; memory, messages,
    /// semaphores and keys shared by number or name; namespaces, which give rights that a process has not outside (see
    /// [`SPACES`]); news of others' files, and files by a handle in place of a path; and permissions, owners, times and
    /// attributes of files, in which Landlock has no say. Each then fails with `EPERM`.
    const CALLS: [i64; 55] = calls!(
        SYS_socket SYS_io_uring_setup
        SYS_execve SYS_execveat SYS_ptrace SYS_process_vm_readv SYS_process_vm_writev SYS_pidfd_getfd SYS_kcmp
        SYS_perf_event_open SYS_bpf SYS_userfaultfd
        SYS_setpriority SYS_ioprio_set SYS_sched_setaffinity SYS_sched_setattr SYS_sched_setparam SYS_sched_setscheduler
        SYS_migrate_pages SYS_move_pages SYS_process_madvise SYS_process_mrelease
        SYS_shmget SYS_shmat SYS_shmctl SYS_msgget SYS_msgsnd SYS_msgrcv SYS_msgctl SYS_semget SYS_semop SYS_semtimedop
        SYS_semctl SYS_mq_open SYS_mq_unlink SYS_add_key SYS_request_key SYS_keyctl
        SYS_unshare SYS_setns
        SYS_inotify_init1 SYS_inotify_add_watch SYS_fanotify_init SYS_open_by_handle_at
        SYS_fchmod SYS_fchmodat SYS_fchown SYS_fchownat SYS_utimensat SYS_setxattr SYS_lsetxattr SYS_fsetxattr
        SYS_removexattr SYS_lremovexattr SYS_fremovexattr
    );
    /// System calls of this processor alone, for the same purpose.
    #[cfg(target_arch = "x86_64")]
    const OLD_CALLS: [i64; 7] = calls!(
        SYS_chmod SYS_chown SYS_lchown SYS_utime SYS_utimes SYS_futimesat SYS_inotify_init
    );
    #[cfg(not(target_arch = "x86_64"))]
    const OLD_CALLS: [i64; 0] = [];
    /// fchmodat2, setxattrat, removexattrat, file_setattr: one number on all processors, not yet in `libc` for all.
    const NEW_CALLS: [i64; 4] = [452, 463, 466, 469];

    /// Flags for namespaces of a new process: files, control groups, names, memory, users, processes, network.
    const SPACES: [u64; 7] =
        [0x0002_0000, 0x0200_0000, 0x0400_0000, 0x0800_0000, 0x1000_0000, 0x2000_0000, 0x4000_0000];

    /// The filters, which all hold: denied calls fail with `EPERM`, calls that libraries can replace with `ENOSYS`.
    pub fn filters() -> Result<[BpfProgram; 2], BackendError> {
        let rule = |argument, operator, value| {
            SeccompRule::new(vec![SeccompCondition::new(argument, Dword, operator, value)?])
        };
        let all = CALLS.into_iter().chain(OLD_CALLS).chain(NEW_CALLS);
        let mut calls: BTreeMap<i64, Vec<SeccompRule>> = all.map(|call| (call, Vec::new())).collect();
        // The limits of another process; its own are number 0, and can be lowered alone.
        calls.insert(libc::SYS_prlimit64, vec![rule(0, Ne, 0)?]);
        let spaces = SPACES.iter().map(|space| rule(0, MaskedEq(*space), *space)).collect::<Result<_, _>>()?;
        calls.insert(libc::SYS_clone, spaces);
        // Its flags lie in memory, where no filter reads; threads are then started by `clone`.
        let newer = BTreeMap::from([(libc::SYS_clone3, Vec::new())]);
        let filter = |calls, error: i32| {
            let denied = SeccompAction::Errno(error.unsigned_abs());
            let arch = TargetArch::try_from(std::env::consts::ARCH)?;
            BpfProgram::try_from(SeccompFilter::new(calls, SeccompAction::Allow, denied, arch)?)
        };
        Ok([filter(calls, libc::EPERM)?, filter(newer, libc::ENOSYS)?])
    }

    pub fn without_calls() -> Result<(), seccompiler::Error> {
        filters()?.iter().try_for_each(|filter| apply_filter(filter))
    }
}

#[cfg(all(test, target_os = "linux", any(target_arch = "x86_64", target_arch = "aarch64")))]
mod tests {
    use super::confined;
    use landlock::RulesetStatus;
    use seccompiler::sock_filter;
    use std::fs::{self, File, OpenOptions, Permissions};
    use std::io::{self, ErrorKind::PermissionDenied, Read};
    use std::net::{TcpStream, UdpSocket};
    use std::os::unix::{fs::PermissionsExt, net::UnixStream};
    use std::{path::Path, process::Command};

    /// Runs `test` with the paths of two files and their folder, in a thread: rights once given up do not come back.
    fn with_files(test: impl FnOnce(&Path, &Path, &Path) + Send) {
        let folder = tempfile::tempdir().expect("a folder");
        let (own, other) = (folder.path().join("own.raw"), folder.path().join("other.raw"));
        fs::write(&own, "own").expect("written");
        fs::write(&other, "other").expect("written");
        std::thread::scope(|scope| scope.spawn(|| test(&own, &other, folder.path())).join()).expect("no panic");
        let read = |path: &Path| fs::read_to_string(path).expect("this thread may read it");
        assert_eq!((read(&own).as_str(), read(&other).as_str()), ("own", "other"));
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), 2);
    }

    #[track_caller]
    fn assert_denied<T>(asked: io::Result<T>) {
        assert_eq!(asked.map(|_| "granted").map_err(|error| error.kind()), Err(PermissionDenied));
    }

    #[needs::landlock]
    #[test]
    fn a_process_that_decodes_may_read_its_file_and_no_other() {
        with_files(|own, other, folder| {
            File::open(other).expect("nothing is given up yet");
            let mut kept = File::open(own).expect("nothing is given up yet");
            assert_ne!(confined::to_file(own).expect("the kernel takes it"), RulesetStatus::NotEnforced);
            assert_eq!(fs::read_to_string(own).expect("it may be read"), "own");
            let mut text = String::new();
            kept.read_to_string(&mut text).expect("it may still be read");
            assert_denied(File::open(other));
            assert_denied(fs::read_dir(folder));
            assert_denied(File::open("/etc/passwd"));
            assert_denied(OpenOptions::new().write(true).open(own));
            assert_denied(OpenOptions::new().append(true).open(other));
            assert_denied(File::create(folder.join("new")));
            assert_denied(fs::create_dir(folder.join("new")));
            assert_denied(fs::remove_file(own));
            assert_denied(fs::rename(other, folder.join("new")));
            assert_denied(std::os::unix::fs::symlink(own, folder.join("new")));
        });
    }

    #[test]
    fn a_process_that_decodes_starts_nothing_and_has_no_network() {
        with_files(|own, other, _| {
            UdpSocket::bind("127.0.0.1:0").expect("nothing is given up yet");
            let modes = || [own, other].map(|path| fs::metadata(path).expect("it is there").permissions().mode());
            let before = modes();
            confined::without_calls().expect("the kernel takes it");
            assert_denied(UdpSocket::bind("127.0.0.1:0"));
            assert_denied(TcpStream::connect("127.0.0.1:9"));
            assert_denied(UnixStream::connect(own));
            assert_denied(Command::new("/bin/sh").args(["-c", "exit 0"]).status());
            assert_denied(fs::set_permissions(other, Permissions::from_mode(0o777)));
            assert_denied(File::open(own).and_then(|file| file.set_permissions(Permissions::from_mode(0o777))));
            assert_denied(File::open(own).and_then(|file| file.set_modified(std::time::UNIX_EPOCH)));
            assert_eq!(modes(), before);
            let parent = rustix::process::getppid();
            let limits = rustix::process::getrlimit(rustix::process::Resource::Core);
            let limit = |process| rustix::process::prlimit(process, rustix::process::Resource::Core, limits);
            assert_denied(limit(parent).map_err(io::Error::from));
            limit(None).expect("its own may be set");
            assert_denied(rustix::process::setpriority_process(parent, 19).map_err(io::Error::from));
            assert_denied(
                rustix::fs::inotify::init(rustix::fs::inotify::CreateFlags::empty()).map_err(io::Error::from),
            );
            // Threads are still there, and what reads.
            let read = std::thread::scope(|scope| scope.spawn(|| fs::read_to_string(own)).join()).expect("no panic");
            assert_eq!(read.expect("it may be read"), "own");
        });
    }

    /// Error with which a filter answers a call of this number and first argument; 0 where it lets it pass.
    fn answer(filter: &[sock_filter], call: i64, argument: u64) -> u32 {
        let (mut at, mut value) = (0, 0);
        loop {
            let sock_filter { code, jt, jf, k } = filter[at];
            at += 1;
            let jump = |is: bool| usize::from(if is { jt } else { jf });
            match code {
                // The number, the processor, and the halves of the first argument lie at these places.
                0x20 => {
                    value = match k {
                        0 => call as u32,
                        4 if cfg!(target_arch = "x86_64") => 0xc000_003e,
                        4 => 0xc000_00b7,
                        16 => argument as u32,
                        20 => (argument >> 32) as u32,
                        _ => 0,
                    }
                }
                0x54 => value &= k,
                0x05 => at += k as usize,
                0x15 => at += jump(value == k),
                0x25 => at += jump(value > k),
                0x35 => at += jump(value >= k),
                0x06 => return if k == 0x7fff_0000 { 0 } else { k & 0xffff },
                other => panic!("the filter has the instruction {other:#x}"),
            }
        }
    }

    #[test]
    fn what_reaches_other_processes_is_denied_and_what_threads_need_is_not() {
        let filters = confined::filters().expect("filters");
        let errors = |call, argument| filters.each_ref().map(|filter| answer(filter, call, argument));
        let denied = [libc::EPERM.unsigned_abs(), 0];
        let calls = [libc::SYS_add_key, libc::SYS_keyctl, libc::SYS_shmget, libc::SYS_msgget, libc::SYS_unshare];
        let more = [libc::SYS_sched_setaffinity, libc::SYS_ioprio_set, libc::SYS_setns, libc::SYS_execve];
        calls.into_iter().chain(more).for_each(|call| assert_eq!(errors(call, 0), denied, "{call}"));
        assert_eq!((errors(libc::SYS_prlimit64, 1), errors(libc::SYS_prlimit64, 0)), (denied, [0, 0]));
        // A thread, as glibc starts one, and the same with users of its own.
        let thread = 0x003d_0f00;
        assert_eq!((errors(libc::SYS_clone, thread | 0x1000_0000), errors(libc::SYS_clone, thread)), (denied, [0, 0]));
        assert_eq!(errors(libc::SYS_clone3, 0), [0, libc::ENOSYS.unsigned_abs()]);
        assert_eq!(errors(libc::SYS_read, 0), [0, 0]);
    }
}
