#!/usr/bin/env bash
# Siconos 4.4 (Debian 12: libsiconos-kernel-dev and libsiconos-mechanics-dev 4.4.0+dfsg-2): whether its headers compile depends on their
# order, and the order that reads best is the wrong one. After <SiconosKernel.hpp>, the whole of the kernel, a header of mechanics
# (<SiconosShape.hpp>) does not compile: the kernel's visitor is a class whose list of visited types is a macro that <MechanicsFwd.hpp>
# must have filled before. Every header has its guards and includes what it names, so sorting includes, as formatters do, breaks a build.
# Seen (C++17): mechanics alone compiles; kernel, then mechanics: "no matching function for call to 'SiconosVisitor::visit(...)'";
# <MechanicsFwd.hpp>, kernel, mechanics compiles. Exit 0 while that is so.
set -euo pipefail
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
cd "$place"
version=4.4.0+dfsg-2
apt-get download -q libsiconos-{kernel,mechanics,numerics}-dev=$version libboost1.74-dev=1.74.0+ds1-21 >/dev/null
for package in *.deb; do dpkg -x "$package" .; done
headers=usr/include/siconos
compiles() {
  printf '#include <%s>\n' "$@" >order.cpp
  g++ -std=c++17 -isystem $headers -isystem $headers/kernel -isystem $headers/mechanics -isystem $headers/numerics \
    -isystem usr/include -fsyntax-only order.cpp 2>errors
}
compiles SiconosShape.hpp || { cat errors >&2; exit 1; }
echo "mechanics alone: compiles"
compiles MechanicsFwd.hpp SiconosKernel.hpp SiconosShape.hpp || { cat errors >&2; exit 1; }
echo "mechanics' forward declarations, kernel, mechanics: compiles"
if compiles SiconosKernel.hpp SiconosShape.hpp; then
  echo "kernel, then mechanics: compiles; this finding is out of date" >&2
  exit 1
fi
grep -q "no matching function for call to .SiconosVisitor::visit" errors || { cat errors >&2; exit 1; }
echo "kernel, then mechanics: $(grep -m1 -o 'error: .*' errors)"
