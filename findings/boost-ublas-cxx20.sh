#!/usr/bin/env bash
# Boost 1.74 (Debian 12: libboost1.74-dev 1.74.0+ds1-21), boost/numeric/ublas/vector.hpp, with GCC 12:
# a dense vector of double compiles as C++17 and not as C++20. Its storage calls the allocator's own `construct`, which C++20 took
# away from std::allocator. One would look for such an end of support in the compiler's release notes, not in the vector
# of a linear-algebra library; and whatever includes it (Siconos's headers do) is bound to C++17 too.
# Seen: C++17 compiles; C++20: "has no member named 'construct'" in ublas/storage.hpp. Exit 0 while that is so.
set -euo pipefail
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
cd "$place"
apt-get download -q libboost1.74-dev=1.74.0+ds1-21 >/dev/null
dpkg -x libboost1.74-dev_*.deb .
cat >vector.cpp <<'CPP'
#include <boost/numeric/ublas/vector.hpp>
int main() {
  boost::numeric::ublas::vector<double> v(2);
  v(0) = 1;
  return v.size() == 2 ? 0 : 1;
}
CPP
g++ -std=c++17 -isystem usr/include vector.cpp -o vector && ./vector
echo "C++17: compiles and runs"
if g++ -std=c++20 -isystem usr/include vector.cpp -o vector 2>errors; then
  echo "C++20: compiles; this finding is out of date" >&2
  exit 1
fi
grep -q "storage.hpp.*has no member named .construct" errors || { cat errors >&2; exit 1; }
echo "C++20: $(grep -m1 -o "error: .*" errors)"
