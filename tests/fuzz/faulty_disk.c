/* A disk that fails below one folder, for processes that load this before the C library.
 *
 * Every call that writes below the folder is counted. From a certain one on (or that one alone) it
 * fails with an error of choice. Removing files goes on, as it does on a full disk. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/uio.h>
#include <unistd.h>

static char folder[PATH_MAX];
static size_t length;
static long own_calls, *calls = &own_calls, fails_at;
static int fails_with, goes_on;

void faulty_disk_set(const char *below, long at, int error, int persistent) {
    strncpy(folder, below ? below : "", PATH_MAX - 1);
    length = strlen(folder);
    fails_at = at;
    fails_with = error;
    goes_on = persistent;
    __atomic_store_n(calls, 0, __ATOMIC_SEQ_CST);
}

long faulty_disk_calls(void) { return __atomic_load_n(calls, __ATOMIC_SEQ_CST); }

__attribute__((constructor)) static void begin(void) {
    const char *below = getenv("FAULTY_DISK"), *counter = getenv("FAULTY_DISK_COUNTER");
    if (counter) {
        /* One count for a process and all that it starts. */
        int fd = open(counter, O_RDWR);
        void *shared = fd < 0 ? MAP_FAILED
                              : mmap(NULL, sizeof *calls, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
        if (shared != MAP_FAILED) calls = shared;
        if (fd >= 0) close(fd);
    }
    if (below) {
        const char *at = getenv("FAULTY_DISK_AT"), *error = getenv("FAULTY_DISK_ERROR");
        strncpy(folder, below, PATH_MAX - 1);
        length = strlen(folder);
        fails_at = at ? atol(at) : 0;
        fails_with = error ? atoi(error) : ENOSPC;
        goes_on = !getenv("FAULTY_DISK_ONCE");
    }
}

static int below(const char *path) {
    char whole[PATH_MAX];
    if (!length || !path) return 0;
    if (path[0] != '/') {
        if (!getcwd(whole, sizeof whole)) return 0;
        size_t n = strlen(whole);
        snprintf(whole + n, sizeof whole - n, "/%s", path);
        path = whole;
    }
    return strncmp(path, folder, length) == 0 && (path[length] == '/' || !path[length]);
}

static int open_below(int fd) {
    char link[64], path[PATH_MAX];
    if (!length) return 0;
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    int before = errno;
    ssize_t n = readlink(link, path, sizeof path - 1);
    errno = before;
    if (n < 0) return 0;
    path[n] = 0;
    return below(path);
}

/* Counts the call; whether it fails. */
static int fails(void) {
    long now = __atomic_add_fetch(calls, 1, __ATOMIC_SEQ_CST);
    if (fails_at && (goes_on ? now >= fails_at : now == fails_at)) {
        errno = fails_with;
        return 1;
    }
    return 0;
}

#define REAL(type, name, ...)                                   \
    static type (*real)(__VA_ARGS__);                           \
    if (!real) *(void **)&real = dlsym(RTLD_NEXT, #name)

#define OPENS(name)                                                                     \
    int name(const char *path, int flags, ...) {                                        \
        REAL(int, name, const char *, int, ...);                                        \
        va_list rest;                                                                   \
        va_start(rest, flags);                                                          \
        mode_t mode = (flags & (O_CREAT | O_TMPFILE)) ? va_arg(rest, mode_t) : 0;       \
        va_end(rest);                                                                   \
        if ((flags & (O_CREAT | O_TRUNC)) && below(path) && fails()) return -1;         \
        return real(path, flags, mode);                                                 \
    }
OPENS(open)
OPENS(open64)

#define OPENS_AT(name)                                                                  \
    int name(int at, const char *path, int flags, ...) {                                \
        REAL(int, name, int, const char *, int, ...);                                   \
        va_list rest;                                                                   \
        va_start(rest, flags);                                                          \
        mode_t mode = (flags & (O_CREAT | O_TMPFILE)) ? va_arg(rest, mode_t) : 0;       \
        va_end(rest);                                                                   \
        if ((flags & (O_CREAT | O_TRUNC)) && at == AT_FDCWD && below(path) && fails())  \
            return -1;                                                                  \
        return real(at, path, flags, mode);                                             \
    }
OPENS_AT(openat)
OPENS_AT(openat64)

#define FOPENS(name)                                                                    \
    FILE *name(const char *path, const char *mode) {                                    \
        REAL(FILE *, name, const char *, const char *);                                 \
        if (strpbrk(mode, "wa+") && below(path) && fails()) return NULL;                \
        return real(path, mode);                                                        \
    }
FOPENS(fopen)
FOPENS(fopen64)

ssize_t write(int fd, const void *data, size_t n) {
    REAL(ssize_t, write, int, const void *, size_t);
    if (open_below(fd) && fails()) return -1;
    return real(fd, data, n);
}

ssize_t writev(int fd, const struct iovec *parts, int n) {
    REAL(ssize_t, writev, int, const struct iovec *, int);
    if (open_below(fd) && fails()) return -1;
    return real(fd, parts, n);
}

#define PWRITES(name, offset)                                                           \
    ssize_t name(int fd, const void *data, size_t n, offset at) {                       \
        REAL(ssize_t, name, int, const void *, size_t, offset);                         \
        if (open_below(fd) && fails()) return -1;                                       \
        return real(fd, data, n, at);                                                   \
    }
PWRITES(pwrite, off_t)
PWRITES(pwrite64, off64_t)

size_t fwrite(const void *data, size_t size, size_t n, FILE *stream) {
    REAL(size_t, fwrite, const void *, size_t, size_t, FILE *);
    if (length && open_below(fileno(stream)) && fails()) return 0;
    return real(data, size, n, stream);
}

#define FLUSHES(name)                                                                   \
    int name(int fd) {                                                                  \
        REAL(int, name, int);                                                           \
        if (open_below(fd) && fails()) return -1;                                       \
        return real(fd);                                                                \
    }
FLUSHES(fsync)
FLUSHES(fdatasync)

#define SIZES(name, offset)                                                             \
    int name(int fd, offset n) {                                                        \
        REAL(int, name, int, offset);                                                   \
        if (open_below(fd) && fails()) return -1;                                       \
        return real(fd, n);                                                             \
    }
SIZES(ftruncate, off_t)
SIZES(ftruncate64, off64_t)

#define MOVES(name)                                                                     \
    int name(const char *from, const char *to) {                                        \
        REAL(int, name, const char *, const char *);                                    \
        if (below(to) && fails()) return -1;                                            \
        return real(from, to);                                                          \
    }
MOVES(rename)
MOVES(link)

int mkdir(const char *path, mode_t mode) {
    REAL(int, mkdir, const char *, mode_t);
    if (below(path) && fails()) return -1;
    return real(path, mode);
}

ssize_t sendfile(int to, int from, off_t *at, size_t n) {
    REAL(ssize_t, sendfile, int, int, off_t *, size_t);
    if (open_below(to) && fails()) return -1;
    return real(to, from, at, n);
}

ssize_t sendfile64(int to, int from, off64_t *at, size_t n) {
    REAL(ssize_t, sendfile64, int, int, off64_t *, size_t);
    if (open_below(to) && fails()) return -1;
    return real(to, from, at, n);
}
