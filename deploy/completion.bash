# bash completion of downrange and downranged: subcommands and options are asked of the program itself.
_downrange() {
  local program=$1 current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]} help word path=()
  COMPREPLY=()
  help=$("$program" --help 2>/dev/null) || return
  local subcommands
  subcommands=$(sed -n '/^Subcommands:$/,/^$/s/^  \([^ ]\{1,\}\).*/\1/p' <<<"$help")
  for word in "${COMP_WORDS[@]:1:COMP_CWORD-1}"; do
    [[ -n $subcommands && $word != -* ]] && grep -qxF -- "$word" <<<"$subcommands" || continue
    path+=("$word")
    help=$("$program" "${path[@]}" --help 2>/dev/null) || return
    subcommands=$(sed -n '/^Subcommands:$/,/^$/s/^  \([^ ]\{1,\}\).*/\1/p' <<<"$help")
  done
  if [[ $current == -* ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$(sed -n 's/^  \(-h,\)\{0,1\}\(--[a-z0-9-]*\).*/\2/p' <<<"$help")" -- "$current")
  elif [[ $previous == --* ]]; then
    # One of a few words, where the help says which; else a file.
    local choices
    choices=$(sed -n "s/^  $previous [^ ]*:{\([^}]*\)}.*/\1/p" <<<"$help")
    [[ -z $choices ]] || mapfile -t COMPREPLY < <(compgen -W "${choices//,/ }" -- "$current")
  elif [[ -n $subcommands ]]; then
    mapfile -t COMPREPLY < <(compgen -W "$subcommands" -- "$current")
  fi
}
complete -o bashdefault -o default -F _downrange downrange downranged
