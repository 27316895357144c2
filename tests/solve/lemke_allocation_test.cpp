// Counts what LemkeSolver takes from the heap. The sanitizers have a malloc of their own: nothing is counted there.
#include <catch2/catch.hpp>
#include <cstdlib>

#include "lcp_examples.hpp"
#include "perp/solve/lemke.hpp"

#if !defined(__SANITIZE_ADDRESS__)

namespace {
long allocations = 0;  // operator new comes here too
}

extern "C" {
void* __libc_malloc(size_t);
void* __libc_calloc(size_t, size_t);
void* __libc_realloc(void*, size_t);
void* __libc_memalign(size_t, size_t);
void* malloc(size_t size) { return ++allocations, __libc_malloc(size); }
void* calloc(size_t count, size_t size) { return ++allocations, __libc_calloc(count, size); }
void* realloc(void* at, size_t size) { return ++allocations, __libc_realloc(at, size); }
void* aligned_alloc(size_t alignment, size_t size) { return ++allocations, __libc_memalign(alignment, size); }
}

using namespace perp;

TEST_CASE("LemkeSolver allocates nothing after its first solve", "[lemke]") {
  const auto n = GENERATE(6, 40);
  const Lcp first = positive_definite_lcp(1, n), second = positive_definite_lcp(2, n);
  LemkeSolver solver;
  LcpSolution solution;
  const long at_begin = allocations;
  solver.solve(first.A, first.b, solution);
  const long after_first = allocations;
  solver.solve(second.A, second.b, solution);
  const long after_second = allocations;
  REQUIRE(solution.solved());
  REQUIRE(solution.pivots > 1);
  CHECK(after_first > at_begin);  // the counter counts
  CHECK(after_second == after_first);
}

TEST_CASE("LemkeSolver allocates nothing for a degenerate stack of the same size", "[lemke]") {
  const Vector down = Vector::NullaryExpr(18, [](Eigen::Index i) { return i % 6 == 2 ? -0.1 : 0.0; });
  const Lcp lcp = cube_stack_lcp(3, 4, 0.4, down);
  LemkeSolver solver;
  LcpSolution solution;
  solver.solve(lcp.A, lcp.b, solution);
  const long before = allocations;
  solver.solve(lcp.A, lcp.b, solution);
  const long after = allocations;
  REQUIRE(solution.solved());
  CHECK(after == before);
}

TEST_CASE("LemkeSolver's workspace serves a smaller problem without a new one", "[lemke]") {
  const Lcp large = positive_definite_lcp(1, 20), small = positive_definite_lcp(2, 8);
  LemkeSolver solver;
  LcpSolution of_large, of_small;
  of_small.z.resize(8);
  solver.solve(large.A, large.b, of_large);
  const long before = allocations;
  solver.solve(small.A, small.b, of_small);
  const long after = allocations;
  REQUIRE(of_small.solved());
  CHECK(after == before);
}

#endif
