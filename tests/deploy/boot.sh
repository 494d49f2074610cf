#!/usr/bin/env bash
# Boots systemd on an overlay over this machine's files and runs FOLDER/probe. FOLDER is mounted at
# /probe. Writes its output and status to FOLDER/output and FOLDER/status. Nothing else of this
# machine is writable, including /dev and kernel settings.
#   unshare --mount --pid --net --ipc --uts --cgroup --fork --kill-child tests/deploy/boot.sh FOLDER
set -euo pipefail
folder=$1

ip link set lo up
mount --make-rprivate /
layers=$folder/layers
mkdir "$layers"
mount -t tmpfs layers "$layers"
root=$layers/root
mkdir "$root" "$layers/upper" "$layers/work"
mount -t overlay -o "lowerdir=/,upperdir=$layers/upper,workdir=$layers/work" overlay "$root"
mkdir "$root/probe" "$root/outside"
mount --bind "$folder" "$root/probe"

mount -t proc proc "$root/proc"
mount --bind "$root/proc/sys" "$root/proc/sys"
mount -o remount,bind,ro "$root/proc/sys"
mount -t sysfs -o ro sysfs "$root/sys"
if [[ $(stat --file-system --format=%T /sys/fs/cgroup) == cgroup2fs ]]; then
  mount -t cgroup2 cgroup2 "$root/sys/fs/cgroup"
else  # Control groups of version 1, which systemd then uses itself.
  mount -t tmpfs cgroup "$root/sys/fs/cgroup"
  mkdir "$root/sys/fs/cgroup/systemd"
  mount -t cgroup -o none,name=systemd cgroup "$root/sys/fs/cgroup/systemd"
fi
for place in dev run tmp; do
  mount -t tmpfs "$place" "$root/$place"
done
mkdir "$root/dev/pts"
mount -t devpts -o newinstance,ptmxmode=0666 devpts "$root/dev/pts"
ln -s pts/ptmx "$root/dev/ptmx"
for device in full null random tty urandom zero; do
  touch "$root/dev/$device"
  mount --bind "/dev/$device" "$root/dev/$device"
done

# Disables all units of an ordinary boot.
rm -rf "$root"/lib/systemd/system/*.wants "$root"/etc/systemd/system/*.wants
cat > "$root/etc/systemd/system/probe.service" <<'UNIT'
[Unit]
SuccessAction=exit
FailureAction=exit
[Service]
Type=oneshot
ExecStart=/bin/sh -c '/probe/probe >/probe/output 2>&1; echo $? >/probe/status'
UNIT

cd "$root"
pivot_root . outside
exec env --ignore-environment container=test PATH=/usr/sbin:/usr/bin:/sbin:/bin \
  sh -c 'umount --lazy /outside && exec /lib/systemd/systemd --unit=probe.service --log-target=null' \
  </dev/null >/dev/null 2>&1
