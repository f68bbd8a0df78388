#!/usr/bin/env bash
# Tests of the kernels and the networks with AVX-512, for machines without: on a Skylake-X that
# Bochs emulates, under Debian's kernel. Does everything from nothing; the emulation takes about a
# quarter of an hour. Bochs 2.7 has no AVX512_BF16: products in bf16 run as on AVX-512 alone.
set -euo pipefail
cd "$(dirname "$0")/.."

bash cmake/install_packages.sh bochs bochs-term bochsbios bsdutils busybox-static ca-certificates \
  ccache cmake cpio g++ grub-common grub-pc-bin libeigen3-dev libgtest-dev libhwy-dev libssl-dev \
  mtools ninja-build nlohmann-json3-dev vgabios xorriso zlib1g-dev
export CCACHE_BASEDIR=$PWD CCACHE_NOHASHDIR=1
tests=(nn_{isa,matmul,attention,sinkhorn,softmax,superpoint,superglue,conv3x3}_test)
build=$PWD/build/nn_only
cmake -G Ninja -B "$build" -DCMAKE_BUILD_TYPE=Release -DGLUEVO_NN_ONLY=ON >/dev/null
cmake --build "$build" --target "${tests[@]}"

work=$PWD/build/avx512
root=$work/root
rm -rf "$work"
mkdir -p "$work/iso/boot/grub" "$root"/{bin,dev,proc,sys,"$PWD/tests"}

# A first file system with the tests, what they load, and a first process that runs them.
cp "$(command -v busybox)" "$root/bin/busybox"
cp -r tests/data "$root$PWD/tests/data"
for test in "${tests[@]}"; do
  strip -o "$root/$test" "$build/tests/nn/$test"
  ldd "$root/$test" | grep -o '/lib[^ ]*' | while read -r library; do
    mkdir -p "$root$(dirname "$library")"
    cp -Ln "$library" "$root$library"
  done
done
cat > "$root/init" <<END
#!/bin/busybox sh
for type in proc sysfs devtmpfs; do
  case \$type in devtmpfs) to=/dev ;; *) to=/\${type%fs} ;; esac
  /bin/busybox mount -t \$type \$type \$to
done
exec >/dev/ttyS0 2>&1
tests="${tests[*]}"
/bin/busybox grep -q avx512f /proc/cpuinfo || { echo "Linux does without AVX-512"; tests=; }
for test in \$tests; do
  case \$test in
    nn_super*) filter='*avx512*' ;;
    nn_conv3x3_test) filter='-*ManyChannels:*AcrossSegments*' ;;
    *) filter='*' ;;
  esac
  /\$test --gtest_filter="\$filter" && echo "\$test passed" || echo "\$test failed"
done
/bin/busybox sleep 5  # What was written last is still on its way.
/bin/busybox poweroff -f
END
chmod +x "$root/init"
(cd "$root" && find . | cpio --quiet -o -H newc) > "$work/iso/boot/initrd"

# The kernel's package is downloaded, not installed.
package=$(apt-cache depends linux-image-cloud-amd64 | sed -n 's/.*Depends: //p' | head -n 1)
(cd "$work" && apt-get -qq download "$package" && dpkg-deb -x "$package"_*.deb kernel)
cp "$work"/kernel/boot/vmlinuz-* "$work/iso/boot/vmlinuz"
# Bochs and Linux do not agree on the size of the compact form of the registers' state (XSAVES, and
# XSAVEC, which is flag 321), and then Linux does without AVX.
cat > "$work/iso/boot/grub/grub.cfg" <<END
set timeout=0
menuentry tests {
  linux /boot/vmlinuz console=ttyS0 quiet noxsaves clearcpuid=321 tsc=reliable lpj=1000000
  initrd /boot/initrd
}
END
grub-mkrescue -o "$work/tests.iso" "$work/iso" 2>/dev/null

cat > "$work/bochsrc" <<END
cpu: model=corei7_skylake_x, ips=50000000
memory: guest=1024, host=1024
romimage: file=/usr/share/bochs/BIOS-bochs-latest
vgaromimage: file=/usr/share/bochs/VGABIOS-lgpl-latest
ata0-master: type=cdrom, path=$work/tests.iso, status=inserted
boot: cdrom
com1: enabled=1, mode=file, dev=$work/serial.txt
log: $work/bochs.log
display_library: term
panic: action=report
error: action=ignore
info: action=ignore
END
# Debian's Bochs waits for a command to go on and wants a terminal; the emulated screen is another
# one, and Bochs stops when nobody reads it.
echo c > "$work/commands"
TERM=xterm script -qfc "stty rows 50 cols 130; bochs -q -f $work/bochsrc -rc $work/commands" \
  "$work/screen.txt" </dev/null >/dev/null &
until screen=$(grep -ao '/dev/pts/[0-9]*' "$work/screen.txt" 2>/dev/null); do
  sleep 1
  kill -0 $!
done
(cat "$screen" >/dev/null 2>&1 || true) &
wait

tr -d '\r' < "$work/serial.txt"
passed=$(grep -c '^nn_.* passed' "$work/serial.txt" || true)
echo "$passed of ${#tests[@]} programs passed with AVX-512"
[ "$passed" -eq ${#tests[@]} ]
