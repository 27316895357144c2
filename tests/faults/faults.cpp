// Preloaded into perp (LD_PRELOAD): makes the k-th call of one kind fail, as a full disk, a lost server or a limit would.
//   PERP_FAULT=write|close|sync|lock|thread|truncate|rename   the kind
//   PERP_FAULT_AT=K                                            which call fails, from 1; 0: none
//   PERP_FAULT_COUNT=FILE                                      gets the number of calls at the end
// Calls on what is no regular file (pipes, terminals) are not counted, nor closes of what was opened for reading.
#include <dlfcn.h>
#include <fcntl.h>
#include <pthread.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace {

std::atomic<long> calls{0};

/// Whether this call of `kind` is the one to fail.
bool fails(const char* kind) {
  const char *wanted = std::getenv("PERP_FAULT"), *at = std::getenv("PERP_FAULT_AT");
  if (wanted == nullptr || at == nullptr || std::strcmp(wanted, kind) != 0) return false;
  return ++calls == std::atol(at);
}

bool regular(int file) {
  struct stat found {};
  return fstat(file, &found) == 0 && S_ISREG(found.st_mode);
}

template <class Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

struct Count {
  ~Count() {
    const char* file = std::getenv("PERP_FAULT_COUNT");
    if (file == nullptr) return;
    unsetenv("PERP_FAULT");
    if (std::FILE* out = std::fopen(file, "w")) {
      std::fprintf(out, "%ld\n", calls.load());
      std::fclose(out);
    }
  }
} count;

}  // namespace

extern "C" {

ssize_t pwrite(int file, const void* bytes, size_t size, off_t at) {
  if (regular(file) && fails("write")) {
    errno = ENOSPC;
    return -1;
  }
  if (regular(file) && size > 1 && fails("short-write"))
    size /= 2;  // taken, as a disk may; the writer goes on
  return next<ssize_t(int, const void*, size_t, off_t)>("pwrite")(file, bytes, size, at);
}

ssize_t pwrite64(int file, const void* bytes, size_t size, off64_t at) {
  return pwrite(file, bytes, size, at);
}

int close(int file) {
  const bool written = regular(file) && (fcntl(file, F_GETFL) & O_ACCMODE) != O_RDONLY;
  const bool failing = written && fails("close");
  const int result = next<int(int)>("close")(file);
  if (!failing) return result;
  errno = EIO;
  return -1;
}

int fdatasync(int file) {
  if (fails("sync")) {
    errno = EIO;
    return -1;
  }
  return next<int(int)>("fdatasync")(file);
}

int flock(int file, int operation) {
  if (fails("lock")) {
    errno = ENOLCK;
    return -1;
  }
  return next<int(int, int)>("flock")(file, operation);
}

int ftruncate(int file, off_t size) {
  if (fails("truncate")) {
    errno = EIO;
    return -1;
  }
  return next<int(int, off_t)>("ftruncate")(file, size);
}

int ftruncate64(int file, off64_t size) { return ftruncate(file, size); }

int rename(const char* from, const char* to) {
  if (fails("rename")) {
    errno = EACCES;
    return -1;
  }
  return next<int(const char*, const char*)>("rename")(from, to);
}

int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*start)(void*),
                   void* argument) {
  if (fails("thread")) return EAGAIN;
  return next<int(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*)>("pthread_create")(
      thread, attributes, start, argument);
}

}  // extern "C"
