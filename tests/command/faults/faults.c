/* Calls of the system that fail: the SRP_FAULT_AT-th of those that are counted, by the way that SRP_FAULT names. To
 * be loaded before the C library. What is counted is said to the file SRP_FAULT_COUNT at the end. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

enum way { PASS, FULL, BROKEN, AGAIN, SHORT, DEATH };

static long counted, at;
static enum way way;

__attribute__((constructor)) static void begin(void)
{
    const char *names[] = {"pass", "full", "broken", "again", "short", "death"};
    const char *name = getenv("SRP_FAULT"), *place = getenv("SRP_FAULT_AT");
    for (int i = 0; name && i < 6; i++)
        if (!strcmp(name, names[i]))
            way = (enum way)i;
    at = place ? atol(place) : 0;
}

__attribute__((destructor)) static void end(void)
{
    const char *path = getenv("SRP_FAULT_COUNT");
    FILE *file = path ? fopen(path, "w") : NULL;
    if (file) {
        fprintf(file, "%ld", counted);
        fclose(file);
    }
}

/* The way in which this call fails. */
static enum way next(void)
{
    enum way now = __atomic_add_fetch(&counted, 1, __ATOMIC_SEQ_CST) == at ? way : PASS;
    if (now == DEATH)
        kill(getpid(), SIGKILL);
    return now;
}

/* True if the call fails, with its reason. */
static int fails(enum way now)
{
    errno = now == FULL ? ENOSPC : now == AGAIN ? EINTR : EIO;
    return now == FULL || now == BROKEN || now == AGAIN;
}

#define REAL(result, name, ...)                                                                     \
    static result (*real)(__VA_ARGS__);                                                             \
    if (!real)                                                                                      \
        real = (result(*)(__VA_ARGS__))dlsym(RTLD_NEXT, name)

ssize_t write(int file, const void *bytes, size_t count)
{
    REAL(ssize_t, "write", int, const void *, size_t);
    enum way now = next();
    if (fails(now))
        return -1;
    return real(file, bytes, now == SHORT && count > 1 ? count / 2 : count);
}

ssize_t read(int file, void *bytes, size_t count)
{
    REAL(ssize_t, "read", int, void *, size_t);
    enum way now = next();
    if (fails(now))
        return -1;
    return real(file, bytes, now == SHORT && count > 1 ? count / 2 : count);
}

int rename(const char *from, const char *to)
{
    REAL(int, "rename", const char *, const char *);
    enum way now = next();
    return now != AGAIN && fails(now) ? -1 : real(from, to);
}

int fsync(int file)
{
    REAL(int, "fsync", int);
    return fails(next()) ? -1 : real(file);
}

int fdatasync(int file)
{
    REAL(int, "fdatasync", int);
    return fails(next()) ? -1 : real(file);
}

int mkdir(const char *path, mode_t mode)
{
    REAL(int, "mkdir", const char *, mode_t);
    enum way now = next();
    return now != AGAIN && fails(now) ? -1 : real(path, mode);
}

int unlink(const char *path)
{
    REAL(int, "unlink", const char *);
    enum way now = next();
    return now == BROKEN && fails(now) ? -1 : real(path);
}

int open64(const char *path, int flags, ...)
{
    va_list rest;
    va_start(rest, flags);
    mode_t mode = flags & (O_CREAT | O_TMPFILE) ? va_arg(rest, mode_t) : 0;
    va_end(rest);
    REAL(int, "open64", const char *, int, ...);
    enum way now = next();
    if (fails(now) && (now != FULL || flags & O_CREAT))
        return -1;
    return real(path, flags, mode);
}
