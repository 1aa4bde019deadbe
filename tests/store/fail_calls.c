/* Preloaded into a test (LD_PRELOAD): makes one call of the system fail, as a disk would. Counts what is asked of files below
 * FAIL_ROOT between an open of FAIL_ROOT/ARM and one of FAIL_ROOT/DISARM; the call number FAIL_AT, and with FAIL_LASTING all
 * after it, fail with FAIL_ERRNO, or write half where FAIL_SHORT is set. The process is killed before the call number KILL_AT,
 * in the middle of it where it writes. FAIL_ROOT.calls gets the number of calls. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <unistd.h>

enum { OPEN = 1, WRITE = 2, SYNC = 4, RENAME = 8 };
/* What strikes returns for a write that a kill interrupts. */
enum { KILL = -1 };

static int armed;
static long calls;

static long number(const char *name) {
    const char *text = getenv(name);
    return text ? atol(text) : 0;
}

static int is_below(const char *path) {
    const char *root = getenv("FAIL_ROOT");
    return root && path && strncmp(path, root, strlen(root)) == 0 && path[strlen(root)] == '/';
}

static int strikes(int kind, const char *path) {
    if (!armed || !is_below(path)) return 0;
    long now = calls++;
    if (now == number("KILL_AT")) {
        if (kind == WRITE) return KILL;
        kill(getpid(), SIGKILL);
    }
    long at = number("FAIL_AT");
    if (!(now == at || (number("FAIL_LASTING") && now > at))) return 0;
    return (number("FAIL_KINDS") & kind) != 0;
}

static int strikes_fd(int kind, int fd) {
    if (!armed) return 0;
    char link[64], path[4096];
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    ssize_t length = readlink(link, path, sizeof path - 1);
    if (length <= 0) return 0;
    path[length] = 0;
    return strikes(kind, path);
}

static int fail(void) {
    errno = (int)number("FAIL_ERRNO");
    return -1;
}

static void mark(const char *path) {
    const char *root = getenv("FAIL_ROOT");
    if (!root || !path) return;
    const char *name = strrchr(path, '/');
    if (!name || !is_below(path)) return;
    if (strcmp(name, "/ARM") == 0) armed = 1;
    if (strcmp(name, "/DISARM") == 0) {
        armed = 0;
        char file[4096], text[32];
        snprintf(file, sizeof file, "%s.calls", root);
        int length = snprintf(text, sizeof text, "%ld", calls);
        long fd = syscall(SYS_openat, AT_FDCWD, file, O_CREAT | O_WRONLY | O_TRUNC, 0600);
        if (fd >= 0) {
            (void)!syscall(SYS_write, fd, text, length);
            syscall(SYS_close, fd);
        }
    }
}

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

#define OPEN_CALL(name)                                                   \
    int name(const char *path, int flags, ...) {                          \
        va_list more;                                                     \
        va_start(more, flags);                                            \
        int mode = (flags & (O_CREAT | O_TMPFILE)) ? va_arg(more, int) : 0; \
        va_end(more);                                                     \
        mark(path);                                                       \
        if (strikes(OPEN, path)) return fail();                           \
        return REAL(name)(path, flags, mode);                             \
    }
OPEN_CALL(open)
OPEN_CALL(open64)

#define WRITE_BODY(real, shorter)                                         \
    int struck = strikes_fd(WRITE, fd);                                   \
    if (struck) {                                                         \
        if (size >= 2 && (struck == KILL || number("FAIL_SHORT"))) (void)!(shorter); \
        if (struck == KILL) kill(getpid(), SIGKILL);                      \
        return fail();                                                    \
    }                                                                     \
    return real;
ssize_t write(int fd, const void *bytes, size_t size) {
    WRITE_BODY(REAL(write)(fd, bytes, size), REAL(write)(fd, bytes, size / 2))
}
ssize_t pwrite(int fd, const void *bytes, size_t size, off_t at) {
    WRITE_BODY(REAL(pwrite)(fd, bytes, size, at), REAL(pwrite)(fd, bytes, size / 2, at))
}
ssize_t pwrite64(int fd, const void *bytes, size_t size, off64_t at) {
    WRITE_BODY(REAL(pwrite64)(fd, bytes, size, at), REAL(pwrite64)(fd, bytes, size / 2, at))
}
#define TRUNCATE_BODY(real)                          \
    int struck = strikes_fd(WRITE, fd);              \
    if (struck == KILL) kill(getpid(), SIGKILL);     \
    return struck ? fail() : real;
int ftruncate(int fd, off_t size) { TRUNCATE_BODY(REAL(ftruncate)(fd, size)) }
int ftruncate64(int fd, off64_t size) { TRUNCATE_BODY(REAL(ftruncate64)(fd, size)) }
int fsync(int fd) { return strikes_fd(SYNC, fd) ? fail() : REAL(fsync)(fd); }
int fdatasync(int fd) { return strikes_fd(SYNC, fd) ? fail() : REAL(fdatasync)(fd); }
int rename(const char *from, const char *to) {
    return strikes(RENAME, from) ? fail() : REAL(rename)(from, to);
}
