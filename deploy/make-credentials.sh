#!/usr/bin/env bash
# Makes a certificate authority, a server certificate and a token. See --help.
set -euo pipefail

usage() {
  cat <<TEXT
Usage: make-credentials.sh FOLDER HOST[,HOST...] [OWNER]

Makes in FOLDER a certificate authority (ca.pem, ca.key), a certificate of a server (server.pem,
server.key; one year) and the file of tokens with a token of OWNER (default: learner). The HOSTs are the
names and addresses by which learners connect. Prints the server's flags and three variables for
learners, who get a copy of ca.pem. Keep ca.key elsewhere. Existing files are not overwritten.
TEXT
}

fail() {
  echo "make-credentials.sh: $1" >&2
  exit 2
}

[[ ${1:-} != --help && ${1:-} != -h ]] || { usage; exit 0; }
[[ $# -eq 2 || $# -eq 3 ]] || { usage >&2; exit 2; }
hosts=$2 owner=${3:-learner} names=
for host in ${hosts//,/ }; do
  if [[ $host =~ ^[0-9.]+$ || $host =~ ^[0-9a-fA-F:]*:[0-9a-fA-F:.]*:[0-9a-fA-F:.]*$ ]]; then
    names+=${names:+,}IP:$host
  elif [[ $host =~ ^[A-Za-z0-9-][A-Za-z0-9.-]{0,252}$ ]]; then
    names+=${names:+,}DNS:$host
  else
    fail "host '$host', allowed: DNS names and IP addresses, without ports"
  fi
done
[[ -n $names ]] || fail "HOST is missing"
[[ $owner =~ ^[!-~]{1,128}$ && $owner != *#* ]] ||
  fail "owner '$owner', allowed: 1 to 128 printable ASCII characters without spaces and without #"

mkdir -p "$1"
folder=$(cd "$1" && pwd)
for file in ca.key ca.pem server.key server.pem tokens; do
  [[ ! -e $folder/$file && ! -L $folder/$file ]] || fail "$folder/$file exists and is not overwritten"
done
# Files appear complete or not at all.
new=$(mktemp -d "$folder/new.XXXXXX")
trap 'rm -rf "$new"' EXIT
umask 077
request() {  # request NAME SUBJECT: makes a key and a request for its certificate
  openssl req -new -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -keyout "$new/$1.key" -subj "/CN=$2" 2>/dev/null
}
request ca "procgen authority" | openssl x509 -req -signkey "$new/ca.key" -days 3650 -out "$new/ca.pem" -extfile <(
  printf '%s\n' basicConstraints=critical,CA:TRUE keyUsage=critical,keyCertSign,cRLSign subjectKeyIdentifier=hash) 2>/dev/null
request server procgen-server |
  openssl x509 -req -CA "$new/ca.pem" -CAkey "$new/ca.key" -days 365 -out "$new/server.pem" -extfile <(
    printf '%s\n' basicConstraints=critical,CA:FALSE keyUsage=critical,digitalSignature extendedKeyUsage=serverAuth \
      authorityKeyIdentifier=keyid "subjectAltName=$names") 2>/dev/null || fail "openssl rejects the hosts $hosts"
token=$(openssl rand -hex 32)
echo "$owner $token" >"$new/tokens"
chmod 644 "$new"/*.pem
mv -n "$new"/* "$folder"

shown=${hosts%%,*}
[[ $shown != *:* ]] || shown="[$shown]"
cat <<TEXT
# The server's flags:
--address=0.0.0.0:50051
--tls_certificate=$folder/server.pem
--tls_key=$folder/server.key
--tokens=$folder/tokens
# The learner's environment, with a copy of ca.pem:
export PROCGEN_SERVER=$shown:50051
export PROCGEN_SERVER_CA=$folder/ca.pem
export PROCGEN_SERVER_TOKEN=$token
TEXT
