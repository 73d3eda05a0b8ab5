# What the tests need beside Rust: sourced by run.sh.
#
# Each row: a Debian or Ubuntu package, and how to see that what it brings is there, from that package or elsewhere.
# A C compiler links; Mesa brings a Vulkan adapter in software; the rest opens a window under a virtual display,
# whose libraries are loaded when the program runs.
NEEDS='
gcc                  program cc
libc6-dev            file    /usr/include/stdlib.h
mesa-vulkan-drivers  icd     lvp_icd
libvulkan1           library libvulkan.so.1
xvfb                 program xvfb-run
xvfb                 program Xvfb
xauth                program xauth
libx11-6             library libX11.so.6
libx11-xcb1          library libX11-xcb.so.1
libxcursor1          library libXcursor.so.1
libxi6               library libXi.so.6
libxkbcommon0        library libxkbcommon.so.0
libxkbcommon-x11-0   library libxkbcommon-x11.so.0
'

is_there() { # KIND NAME
  case $1 in
    program) command -v "$2" >/dev/null 2>&1 ;;
    file) [ -e "$2" ] ;;
    library) grep -qF "$2 " <<<"$LIBRARIES" ;;
    icd)
      local folder
      for folder in /usr/share/vulkan/icd.d /usr/local/share/vulkan/icd.d /etc/vulkan/icd.d; do
        compgen -G "$folder/$2*.json" >/dev/null && return 0
      done
      # Another driver may be chosen by hand.
      [ -n "${VK_DRIVER_FILES:-${VK_ICD_FILENAMES:-}}" ]
      ;;
  esac
}

# Packages whose part is absent, one a line.
missing() {
  local package kind name
  LIBRARIES=$(PATH="$PATH:/sbin:/usr/sbin" ldconfig -p 2>/dev/null || true)
  while read -r package kind name; do
    [ -z "$package" ] || is_there "$kind" "$name" || printf '%s\n' "$package"
  done <<<"$NEEDS" | sort -u
}

# Installs what is missing where apt and the right to use it are there; otherwise names it and fails.
install_needs() {
  local absent as_root=()
  if ! command -v cargo >/dev/null 2>&1; then
    echo 'missing: Rust (cargo), see https://rustup.rs' >&2
    return 1
  fi
  if ! cargo fmt --version >/dev/null 2>&1 || ! cargo clippy --version >/dev/null 2>&1; then
    if ! rustup component add rustfmt clippy; then
      echo 'missing: the Rust components rustfmt and clippy' >&2
      return 1
    fi
  fi
  if [ "$(uname -s)" != Linux ]; then
    echo 'the window is tested under Xvfb, on Linux: elsewhere that test fails' >&2
    return 0
  fi
  absent=$(missing)
  [ -n "$absent" ] || return 0
  if [ "$(id -u)" -ne 0 ]; then
    if [ -t 0 ]; then as_root=(sudo); else as_root=(sudo -n); fi
  fi
  if command -v apt-get >/dev/null 2>&1 && { [ "$(id -u)" -eq 0 ] || "${as_root[@]}" true; }; then
    # Lists that cannot be fetched may still be good enough.
    "${as_root[@]}" apt-get update >&2 || true
    # shellcheck disable=SC2086  # one word a package
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
      apt-get install -y --no-install-recommends $absent >&2 || true
    absent=$(missing)
    [ -n "$absent" ] || return 0
  fi
  printf 'missing, by their names on Debian and Ubuntu: %s\n' "$(tr '\n' ' ' <<<"$absent")" >&2
  return 1
}
