#pragma once
/// Counts what a stretch of code takes from the heap. Include it in one file of an executable: it replaces malloc,
/// which operator new and Eigen both use. Under sanitizers, which have a malloc of their own, nothing is counted.

#include <cstddef>
#include <cstdlib>

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define DOWNRANGE_COUNTS_ALLOCATIONS 1
extern "C" void* __libc_malloc(std::size_t);

namespace downrange::test {
inline thread_local std::size_t allocations = 0;
}

extern "C" void* malloc(std::size_t size) {
  ++downrange::test::allocations;
  return __libc_malloc(size);
}
#endif

namespace downrange::test {

/// Heap allocations of this thread while `work` runs; 0 where they are not counted.
template <class Work>
std::size_t allocations_of(const Work& work) {
#ifdef DOWNRANGE_COUNTS_ALLOCATIONS
  const std::size_t before = allocations;
  work();
  return allocations - before;
#else
  work();
  return 0;
#endif
}

}  // namespace downrange::test
