#!/usr/bin/env bash
# Simbody 3.7 (Debian 12: libsimbody-dev 3.7+dfsg-3), with GCC 12: a file that has the one line #include <Simbody.h> compiles as C++17
# and not as C++20. Its index types compare by several conversions and overloads among which C++20's reversed
# comparisons leave no best one, so the library's own inline functions are ambiguous, before a user has written any comparison.
# Seen: C++17 compiles; C++20: "ambiguous overload for 'operator=='" in simmath and simbody headers. Exit 0 while that is so.
set -euo pipefail
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
cd "$place"
apt-get download -q libsimbody-dev=3.7+dfsg-3 >/dev/null
dpkg -x libsimbody-dev_*.deb .
echo '#include <Simbody.h>' >simbody.cpp
g++ -std=c++17 -isystem usr/include/simbody -fsyntax-only simbody.cpp
echo "C++17: compiles"
if g++ -std=c++20 -isystem usr/include/simbody -fsyntax-only simbody.cpp 2>errors; then
  echo "C++20: compiles; this finding is out of date" >&2
  exit 1
fi
grep -q "ContactGeometry.h.*ambiguous overload for .operator==" errors || { cat errors >&2; exit 1; }
echo "C++20: $(grep -c 'error:' errors) errors, the first: $(grep -m1 -o 'error: ambiguous.*' errors)"
