/* A part of a simulator that is nobody's friend: it runs when the library is loaded, inside the sandbox. */
#define _GNU_SOURCE
#include <errno.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <unistd.h>

static void told(const char *what, long result)
{
    dprintf(2, "%s: %s\n", what, result >= 0 ? "DONE" : "refused");
}

static long opened(const char *path, int flags)
{
    return open(path, flags | O_CLOEXEC, 0600);
}

static int deeper(volatile int *above)
{
    volatile int here[256];
    here[0] = above ? *above + 1 : 0;
    return deeper(here) + here[0];
}

static void tries(void)
{
    told("read /etc/passwd", opened("/etc/passwd", O_RDONLY));
    told("read /proc/1/environ", opened("/proc/1/environ", O_RDONLY));
    told("list /", opened("/", O_RDONLY | O_DIRECTORY));
    told("read outside", opened("../untrusted-attack-outside/secret", O_RDONLY));
    told("write outside", opened("../untrusted-attack-outside/secret", O_WRONLY));
    told("make outside", opened("../untrusted-attack-outside/new", O_WRONLY | O_CREAT));
    told("make in /tmp", opened("/tmp/srp-untrusted-attack", O_WRONLY | O_CREAT));
    told("make beside the inputs", opened("new", O_WRONLY | O_CREAT));
    told("write an input", opened("f.c", O_WRONLY));
    told("truncate an input", truncate("f.c", 0));
    told("remove an input", unlink("f.c"));
    told("link", symlink("/etc/passwd", "stolen"));
    told("hard link", link("../untrusted-attack-outside/secret", "stolen"));
    told("change rights", chmod("../untrusted-attack-outside/secret", 0777));
    told("fork", syscall(SYS_fork));
    told("vfork", syscall(SYS_clone, SIGCHLD, 0, 0, 0, 0));
    told("clone3", syscall(SYS_clone3, 0, 0));
    char *args[] = {"/bin/true", NULL};
    told("exec", execve(args[0], args, NULL));
    told("socket", socket(AF_INET, SOCK_STREAM, 0));
    told("socket of files", socket(AF_UNIX, SOCK_STREAM, 0));
    told("signal to the guard", kill(getppid(), 0));
    told("signal to all", kill(-1, 0));
    told("trace the guard", ptrace(PTRACE_ATTACH, getppid(), 0, 0));
    told("mount", mount("none", "/mnt", "tmpfs", 0, 0));
    told("change root", chroot("/"));
    struct rlimit more = {RLIM_INFINITY, RLIM_INFINITY};
    told("raise limits", setrlimit(RLIMIT_AS, &more));
    told("raise time", setrlimit(RLIMIT_CPU, &more));
    told("memory of files", syscall(SYS_memfd_create, "x", 0));
    told("rings", syscall(SYS_io_uring_setup, 1, 0));
    told("new names", syscall(SYS_unshare, 0x10000000));
    told("outlive the guard", prctl(PR_SET_PDEATHSIG, 0));
    void *much = mmap(NULL, 8UL << 30, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    told("take 8 GiB", much == MAP_FAILED ? -1 : 0);
    dprintf(2, "all was tried\n");
}

__attribute__((constructor)) static void attack(void)
{
    /* Work that is not confined has the user's variables. */
    if (getenv("PATH"))
        return;
    char mode[16] = "";
    int file = opened("mode", O_RDONLY);
    if (file < 0 || read(file, mode, sizeof mode - 1) <= 0)
        return;
    if (!strcmp(mode, "try"))
        tries();
    else if (!strcmp(mode, "abort"))
        abort();
    else if (!strcmp(mode, "crash"))
        *(volatile int *)8 = 1;
    else if (!strcmp(mode, "recurse"))
        deeper(NULL);
    else if (!strcmp(mode, "eat"))
        for (;;) {
            char *more = malloc(1 << 20);
            if (!more)
                abort();
            memset(more, 1, 1 << 20);
        }
    else if (!strcmp(mode, "spin"))
        for (;;)
            signal(SIGXCPU, SIG_IGN);
    else if (!strcmp(mode, "sleep"))
        for (;;)
            usleep(1000);
}
