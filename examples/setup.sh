# Sourced by examples/run and tests/run from the project's root: installs what is missing, configures, builds.

required=(g++ cmake ninja-build libeigen3-dev libcli11-dev libtoml11-dev libboost-dev catch2)
optional=(gnuplot-nox coinor-libipopt-dev libnlopt-dev libqhull-dev libsundials-dev libhdf5-dev liburdfdom-dev clang-format doxygen)

say() { printf '== %s\n' "$*"; }

# Those of the packages named that are not installed, one a line.
missing() {
  local package
  for package in "$@"; do
    [[ $(dpkg-query -W -f '${db:Status-Status}' "$package" 2>/dev/null) == installed ]] || printf '%s\n' "$package"
  done
}

apt() {
  local as_root=()
  ((EUID == 0)) || as_root=(sudo)
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -o DPkg::Lock::Timeout=600 -o Acquire::Retries=3 \
    --quiet --quiet --yes --no-install-recommends "$@" </dev/null >/dev/null
}

# Twice, since another apt may hold the lists or the network stumble.
apt_twice() { apt "$@" || { sleep 10 && apt "$@"; }; }

install_packages() {
  local needed wanted package
  if ! command -v dpkg-query >/dev/null || ! command -v apt-get >/dev/null; then
    say "not a Debian system: taking what is installed of ${required[*]} ${optional[*]}"
    return
  fi
  mapfile -t needed < <(missing "${required[@]}")
  mapfile -t wanted < <(missing "${optional[@]}")
  ((${#needed[@]} + ${#wanted[@]})) || return 0
  say "installing by apt: ${needed[*]} ${wanted[*]}"
  apt_twice update
  apt_twice install "${needed[@]}" "${wanted[@]}" && return
  say "not all of them at once: what is required first, then the others one by one"
  ((${#needed[@]} == 0)) || apt_twice install "${needed[@]}"
  for package in "${wanted[@]}"; do
    apt install "$package" || say "$package could not be installed: going on without it"
  done
}

cores() { nproc 2>/dev/null || echo 2; }

# configure SOURCE FOLDER [CMAKE-ARGUMENT...]: silent unless it fails or an optional package is not there.
configure() {
  local source=$1 folder=$2 generator=() log
  shift 2
  [[ -f $folder/CMakeCache.txt ]] || generator=(-G Ninja)
  log=$(cmake -S "$source" -B "$folder" "${generator[@]}" "$@" 2>&1) || { printf '%s\n' "$log"; return 1; }
  grep 'is not installed' <<<"$log" || true
}

# build FOLDER [TARGET...]: with all cores.
build() {
  local folder=$1 targets=()
  shift
  (($# == 0)) || targets=(--target "$@")
  cmake --build "$folder" --parallel "$(cores)" "${targets[@]}"
}
