#!/bin/sh
# Runs what the image would run, without a container engine: entrypoint, command, user, environment and read-only root
# as docker/Dockerfile states them, in a root of Debian's packages and the program alone.
#
#   sudo docker/try_image.sh TABLETOPGEN [ROOT]
#
# TABLETOPGEN is the program, as built. ROOT is a folder with a minimal Debian; a missing one is made with debootstrap
# (network, two minutes). Needs root for mounts, python3, unshare and setpriv (util-linux). What it leaves behind: ROOT.
#
# Not covered: the build stage of the Dockerfile, image layers, the networks of compose and Kubernetes.
set -eu

[ $# -ge 1 ] || { sed -n '2,/^set/s/^# \{0,1\}//p' "$0" >&2; exit 2; }
program=$(realpath "$1")
here=$(dirname "$(realpath "$0")")
root=$(realpath -m "${2:-/var/tmp/tabletopgen-root}")
port=${PORT:-18080}

if [ ! -x "$root/usr/bin/env" ]; then
    debootstrap --variant=minbase bookworm "$root" >&2
fi

work=$(mktemp -d)
# Ends the server, if it still runs, and with its mount namespace all mounts.
trap 'if [ -n "${server:-}" ]; then kill "$server" 2>/dev/null || true; wait "$server" 2>/dev/null || true; fi; rm -rf "$work"' EXIT

# The layer of the final stage.
install -D --mode=0755 "$program" "$work/layer/usr/local/bin/tabletopgen"
mkdir -p "$work/layer/data" "$work/merged" "$work/data"
if [ -e /etc/ssl/certs/ca-certificates.crt ]; then
    install -D --mode=0644 /etc/ssl/certs/ca-certificates.crt "$work/layer/etc/ssl/certs/ca-certificates.crt"
fi

# What the Dockerfile says of the final stage, one shell word a line.
python3 - "$here/Dockerfile" > "$work/stated" <<'PYTHON'
import json, re, sys
text = open(sys.argv[1]).read().replace("\\\n", " ")
final = text[text.rindex("\nFROM "):]
stated = {name: re.findall(rf"^{name} (.*)$", final, re.M) for name in ("USER", "ENTRYPOINT", "CMD", "ENV", "VOLUME")}
print("user", stated["USER"][-1])
print("entrypoint", *json.loads(stated["ENTRYPOINT"][-1]))
print("command", *json.loads(stated["CMD"][-1]))
print("volume", *json.loads(stated["VOLUME"][-1]))
for line in stated["ENV"]:
    for pair in line.split():
        print("env", pair)
PYTHON
user=$(sed -n 's/^user //p' "$work/stated")
entrypoint=$(sed -n 's/^entrypoint //p' "$work/stated")
environment=$(sed -n 's/^env //p' "$work/stated" | tr '\n' ' ')
echo "user $user, entrypoint $entrypoint, environment $environment"
chown "$user" "$work/data"

# in_image WORDS...: runs them in the image's root: read-only, with /tmp, /data, /proc and a few devices.
cat > "$work/in_image" <<SHELL
#!/bin/sh
set -eu
mount -t overlay overlay -o "lowerdir=$work/layer:$root" "$work/merged"
mount -t tmpfs -o mode=1777 tmpfs "$work/merged/tmp"
mount --bind "$work/data" "$work/merged/data"
mount -t proc proc "$work/merged/proc"
mount -t tmpfs -o mode=0755 tmpfs "$work/merged/dev"
for device in null zero urandom random; do
    touch "$work/merged/dev/\$device"
    mount --bind "/dev/\$device" "$work/merged/dev/\$device"
done
cd "$work/merged"
exec chroot "$work/merged" /usr/bin/env --ignore-environment PATH=/usr/local/bin:/usr/bin:/bin $environment \\
    setpriv --reuid="${user%:*}" --regid="${user#*:}" --clear-groups --no-new-privs --bounding-set=-all --inh-caps=-all \\
    "\$@"
SHELL
chmod +x "$work/in_image"
in_image() { unshare --mount --propagation private "$work/in_image" "$@"; }

echo "--- the root is read-only, and the user has no rights over it"
for path in /written /usr/local/bin/tabletopgen /etc/passwd; do
    if in_image sh -c "echo x >> $path" 2> "$work/refused"; then echo "WRITTEN: $path" >&2; exit 1; fi
    sed 's/^/    /' "$work/refused"
done
in_image sh -c 'echo x > /data/x && rm /data/x && echo x > /tmp/x && echo "    /data and /tmp can be written"'

echo "--- the program's libraries are in the root"
in_image sh -c 'ldd /usr/local/bin/tabletopgen' | sed 's/^/    /'
in_image $entrypoint --version | sed 's/^/    /'

echo "--- the command of the image, beyond loopback without authentication"
command=$(sed -n 's/^command //p' "$work/stated" | sed "s/:8080/:$port/")
set +e
# Word by word, as the image has it.
# shellcheck disable=SC2086
in_image timeout 10 $entrypoint $command > "$work/refusal" 2>&1
echo "    exit code $?"
set -e
sed 's/^/    /' "$work/refusal" | head -5

echo "--- the same with --allow-unauthenticated, then a scene"
# shellcheck disable=SC2086
unshare --mount --propagation private "$work/in_image" $entrypoint $command ${FLAGS---allow-unauthenticated} \
    > "$work/out" 2> "$work/log" &
server=$!
python3 - "$port" "$server" <<'PYTHON' || { tail -5 "$work/log" >&2; exit 1; }
import json, sys, time, urllib.error, urllib.request

port, server = sys.argv[1:3]
started = time.monotonic()


def get(url, data=None):
    headers = {"content-type": "application/json"} if data else {}
    return urllib.request.urlopen(urllib.request.Request(url, data, headers), timeout=70)


def wait_for(what, seconds):
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        try:
            if found := what():
                return found
        except (OSError, urllib.error.URLError):
            pass
        time.sleep(0.1)
    sys.exit(f"gave up after {seconds} s")


wait_for(lambda: get(f"http://127.0.0.1:{port}/readyz").status == 200, 30)
print(f"    ready after {time.monotonic() - started:.1f} s")
status = dict(line.split(":\t") for line in open(f"/proc/{server}/status").read().splitlines() if ":\t" in line)
for name in ("Uid", "Gid", "Groups", "CapEff", "CapBnd", "NoNewPrivs"):
    print(f"    {name} {status[name].strip()}")
api = f"http://127.0.0.1:{port}"
scene = json.load(get(f"{api}/scenes", json.dumps({"text": "a mug and a plate", "seed": 7}).encode()))
job = scene["job"]["id"]


def ended():
    state = json.load(get(f"{api}/jobs/{job}"))["state"]
    return state if state in ("succeeded", "failed", "cancelled") else None


state = wait_for(ended, 300)
bundle = get(f"{api}/scenes/{scene['id']}/bundle").read()
print(f"    job {state}, bundle of {len(bundle)} bytes")
series = sum(not line.startswith("#") for line in get(f"http://127.0.0.1:{port}/metrics").read().decode().splitlines())
print(f"    {series} lines of metrics")
if state != "succeeded":
    sys.exit(1)
PYTHON

echo "--- the stop signal of the image"
kill -TERM "$server"
set +e
wait "$server"
code=$?
set -e
server=
echo "    exit code $code; the last line of the log:"
tail -1 "$work/log" | sed 's/^/    /'
echo "    files of /data: $(find "$work/data" -type f | wc -l), of owner $(stat -c %u:%g "$work/data/tabletopgen.sqlite")"
[ "$code" = 0 ]
