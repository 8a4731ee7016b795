#!/usr/bin/env bash
# The part of scripts/try-debian-packages inside a tree, as root, in a mount namespace of its own. build/try-packages has the
# packages, in new, and in old those of an earlier commit, if there are any. Users' programs run as a user without rights.
set -euo pipefail
sources=$PWD
files=$PWD/build/try-packages
work=/opt/clsdf-try
user=1234

fail() {
    echo "try-debian-packages: $*" >&2
    exit 1
}
say() { echo " $*"; }
quiet() { "$@" </dev/null >$work.log 2>&1 || { tail -n 20 $work.log >&2; fail "'$*' failed"; }; }
as_user() {
    (cd $work && setpriv --reuid $user --regid $user --clear-groups env -i HOME=$work PATH=/usr/bin:/bin LANG=C.UTF-8 "$@")
}
# In the user's folder, as one line of a document.
paste_line() { as_user sh -euc "$1" || fail "this line fails: $1"; }
version_of() { dpkg-query -W -f '${Version}' "$1"; }
clsdf_packages() { dpkg-query -W -f '${db:Status-Status} ${Package}\n' '*clsdf*' 2>/dev/null | sed -n 's/^installed //p'; }
purge_clsdf() {
    local packages
    mapfile -t packages < <(clsdf_packages)
    [ ${#packages[@]} -eq 0 ] || quiet apt-get -y purge "${packages[@]}"
}
installed() { dpkg-query -W -f '${db:Status-Status} ${Package}\n' | grep -v '^not-installed ' | sort; }
# Packages that nothing asks for any more, with those that others only recommend.
tidy() { quiet apt-get -y -o APT::AutoRemove::RecommendsImportant=false -o APT::AutoRemove::SuggestsImportant=false autoremove --purge; }
compute() {
    as_user clsdf shape knot -o knot.off --quiet
    as_user clsdf compute knot.off -o "$1" --resolution 64 --band 10% --quiet
}

rm -rf $work
mkdir $work
chown $user:$user $work
purge_clsdf # of a trial that was stopped
quiet apt-get -qq update
quiet apt-get -y install --no-install-recommends bash-completion cmake g++ gfortran man-db ninja-build pkg-config
tidy
installed >$work.before

say "the command"
command=("$files"/new/{clsdf,libclsdf0.1,libclsdf-reference0.1}_*.deb)
quiet apt-get -y --download-only install "${command[@]}"
began=$SECONDS
quiet apt-get -y install "${command[@]}"
compute first.nrrd
say "from the packages, and what they need, to the first field: $((SECONDS - began)) s"
as_user clsdf check --complete knot.off first.nrrd --quiet
purge_clsdf

if [ -d "$files/old" ]; then
    quiet apt-get -y install "$files"/old/*.deb
    old=$(version_of clsdf)
    compute old.nrrd
fi
quiet apt-get -y install "$files"/new/*.deb
new=$(version_of clsdf)
for package in $(clsdf_packages); do
    [ "$(version_of "$package")" = "$new" ] || fail "$package has the version $(version_of "$package"), and clsdf $new"
done
if [ -d "$files/old" ]; then
    dpkg --compare-versions "$old" lt "$new" || fail "$new is no upgrade of $old"
    say "upgraded from $old to $new"
fi
as_user clsdf --version
for page in clsdf clsdf-compute; do as_user man -w $page >/dev/null || fail "man finds no page $page"; done
as_user bash -c '. /usr/share/bash-completion/completions/clsdf && complete -p clsdf' >/dev/null || fail "bash completes no clsdf"
compute new.nrrd
as_user cmp first.nrrd new.nrrd || fail "another field after the upgrade"

say "documents"
documents=/usr/share/doc/clsdf
# block PAGE LANGUAGE FIRST_LINE prints the first block of code of that language whose first line matches.
block() {
    awk -v begin='```'"$2" -v first="$3" '
        inside && $0 == "```" { exit }
        inside { print }
        before && $0 ~ first { inside = 1; print }
        { before = $0 == begin }' "$documents/$1" | grep . || fail "$documents/$1 has no program in $2 that begins with '$3'"
}
# line PAGE PATTERN prints the first line of the page that matches.
line() { grep -m 1 -E "$2" "$documents/$1" || fail "$documents/$1 has no line '$2'"; }
block README.md cpp '#include' >$work/simulation.cpp
block docs/c.md c '^/[*] first[.]c' >$work/first.c
block docs/c.md c '^/[*] slabs[.]c' >$work/slabs.c
block docs/fortran.md fortran '^! first[.]f90' >$work/first.f90
printf "program files\n  use clsdf_io\n  call clsdf_field_check_path('a.nrrd')\nend program\n" >$work/files.f90
cp $work/knot.off $work/bunny.off
cp -r "$sources/tests/consumer" $work/consumer
chown -R $user:$user $work

say "C++, C and Fortran by CMake"
by_cmake() {
    local folder=$1 build=build-${1//\//-}
    quiet as_user cmake -G Ninja -S "$folder" -B "$build" -DPROGRAMS=$work "${@:2}"
    quiet as_user cmake --build "$build"
}
by_cmake consumer -DWAY=find_package -DCOMPONENTS=io,c -DREADME_PROGRAM=$work/simulation.cpp
by_cmake consumer/c -DCOMPONENTS=c_io
by_cmake consumer/fortran -DCOMPONENTS=fortran_io
for program in build-consumer/{consumer,consumer_files,consumer_both} build-consumer-c/{first,slabs} build-consumer-fortran/{first,files}; do
    quiet as_user ./$program
done

say "the same by pkg-config, as the documents' lines"
compile=$(line docs/install.md '^c[+][+] .*pkg-config' | sed 's/clsdf-meshes/clsdf-io/')
paste_line "$compile && ./simulation"
compile=$(line docs/c.md '^cc .*pkg-config')
paste_line "$compile && ./first"
compile=$(sed 's/clsdf-c/clsdf-c-io/; s/first/slabs/g' <<<"$compile")
paste_line "$compile && ./slabs"
rpath=$(line docs/fortran.md '^rpath=')
for compiler in gfortran fc; do
    compile=$(line docs/fortran.md "^$compiler .*pkg-config" | sed 's/^fc /gfortran -J . /')
    paste_line "$rpath; $compile && ./first"
done

say "removal"
# Users' files are theirs: records of devices in ~/.cache/clsdf.
dpkg -L $(clsdf_packages) | sort -u >$work.files
purge_clsdf
tidy
installed | diff $work.before - || fail "after the removal these packages are left or gone"
while IFS= read -r file; do
    [ -d "$file" ] && [[ $file != *clsdf* ]] || { [ ! -e "$file" ] && [ ! -L "$file" ]; } || fail "the removal left $file"
done <$work.files
say "nothing is left"
rm -rf $work $work.*
