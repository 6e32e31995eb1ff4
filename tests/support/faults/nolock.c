/* A disk without locks, as network disks are at times. Loaded by LD_PRELOAD. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>

#define WITHOUT_LOCKS(name)                                                          \
  int name(int fd, int command, ...) {                                               \
    va_list rest;                                                                    \
    va_start(rest, command);                                                         \
    void *argument = va_arg(rest, void *);                                           \
    va_end(rest);                                                                    \
    if (command == F_SETLK || command == F_SETLKW) {                                 \
      errno = ENOLCK;                                                                \
      return -1;                                                                     \
    }                                                                                \
    return ((int (*)(int, int, ...))dlsym(RTLD_NEXT, #name))(fd, command, argument); \
  }
WITHOUT_LOCKS(fcntl)
WITHOUT_LOCKS(fcntl64)
