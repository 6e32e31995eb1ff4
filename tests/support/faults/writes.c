/* Stands before the calls of the C library that change what is on a disk, and counts them. At one of
   them the process is killed (FAULT_KILL), or they fail from there on with an error of its choice.
   Loaded by LD_PRELOAD; fault_set() begins to count anew, in the process that calls it. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <sys/types.h>
#include <unistd.h>

#define FAULT_KILL 0

static int counted, fault_at, fault_error;

void fault_set(int at, int error) {
  __atomic_store_n(&counted, 0, __ATOMIC_SEQ_CST);
  fault_at = at;
  fault_error = error;
}

int fault_count(void) { return __atomic_load_n(&counted, __ATOMIC_SEQ_CST); }

/* Whether a call is to fail; the process ends here if this is where it is to be killed. */
static int fails(void) {
  int now = __atomic_add_fetch(&counted, 1, __ATOMIC_SEQ_CST);
  if (!fault_at || now < fault_at) return 0;
  if (fault_error == FAULT_KILL) kill(getpid(), SIGKILL);
  errno = fault_error;
  return 1;
}

#define REAL(name, ...) ((int (*)(__VA_ARGS__))dlsym(RTLD_NEXT, name))

ssize_t write(int fd, const void *data, size_t n) {
  return fd > 2 && fails() ? -1
      : ((ssize_t(*)(int, const void *, size_t))dlsym(RTLD_NEXT, "write"))(fd, data, n);
}

#define PWRITE(name)                                                                 \
  ssize_t name(int fd, const void *data, size_t n, off_t at) {                       \
    return fails() ? -1                                                              \
        : ((ssize_t(*)(int, const void *, size_t, off_t))dlsym(RTLD_NEXT, #name))(   \
              fd, data, n, at);                                                      \
  }
PWRITE(pwrite)
PWRITE(pwrite64)

int fsync(int fd) { return fails() ? -1 : REAL("fsync", int)(fd); }
int fdatasync(int fd) { return fails() ? -1 : REAL("fdatasync", int)(fd); }
int ftruncate(int fd, off_t n) { return fails() ? -1 : REAL("ftruncate", int, off_t)(fd, n); }
int ftruncate64(int fd, off_t n) { return fails() ? -1 : REAL("ftruncate64", int, off_t)(fd, n); }

/* What takes things away goes on working on a disk that is full; a kill knows no difference. */
static int takes_away(void) { return fault_error == FAULT_KILL && fails(); }

int unlink(const char *path) { return takes_away() ? -1 : REAL("unlink", const char *)(path); }
int rmdir(const char *path) { return takes_away() ? -1 : REAL("rmdir", const char *)(path); }
int unlinkat(int at, const char *path, int flags) {
  return takes_away() ? -1 : REAL("unlinkat", int, const char *, int)(at, path, flags);
}
int rename(const char *from, const char *to) {
  return fails() ? -1 : REAL("rename", const char *, const char *)(from, to);
}
int mkdir(const char *path, mode_t mode) {
  return fails() ? -1 : REAL("mkdir", const char *, mode_t)(path, mode);
}

#define OPEN(name)                                                                   \
  int name(const char *path, int flags, ...) {                                       \
    va_list rest;                                                                    \
    va_start(rest, flags);                                                           \
    int mode = va_arg(rest, int);                                                    \
    va_end(rest);                                                                    \
    if ((flags & O_CREAT) && fails()) return -1;                                     \
    return REAL(#name, const char *, int, ...)(path, flags, mode);                   \
  }
OPEN(open)
OPEN(open64)
