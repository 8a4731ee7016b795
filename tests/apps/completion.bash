# completion.bash SCRIPT FOLDER: what bash offers after the words of a line, in a folder with a few files.
set -u
source "$1"
cd "$2" && rm -rf try && mkdir -p try/folder && cd try || exit 1
trap 'cd .. && rm -rf try' EXIT
touch mesh.off "two words.stl" field.nrrd picture.png notes.txt

failed=0
# offers EXPECTED WORD...: the last word is the one that is completed.
offers() {
    local expected=$1
    shift
    COMP_WORDS=(clsdf "$@") COMP_CWORD=$# COMPREPLY=()
    _clsdf 2> error
    local offered
    offered=$(printf '%s\n' ${COMPREPLY[@]+"${COMPREPLY[@]}"} | sort | paste -sd ' ')
    [ -s error ] && { cat error; failed=1; }
    if [ "$offered" != "$expected" ]; then
        echo "clsdf $*: offered '$offered' instead of '$expected'"
        failed=1
    fi
}

offers "compute" comp
offers "--sign --size" compute mesh.off --si
offers "auto below none nonzero parity solid-angle" compute --sign ""
offers "none nonzero" compute --sign = no
offers "x y z" slice --axis ""
offers "folder mesh.off two words.stl" compute ""
offers "two words.stl" compute tw
offers "folder mesh.off two words.stl" compute --resolution 9 ""
offers "field.nrrd folder mesh.off two words.stl" check mesh.off ""
offers "field.nrrd folder mesh.off two words.stl" check --seed 3 mesh.off ""
offers "field.nrrd folder" compute mesh.off -o ""
offers "folder picture.png" slice field.nrrd --output = ""
offers "knot" shape kn
offers "shape slice" help s
offers "" compute --resolution ""
offers "--version" --v
exit $failed
