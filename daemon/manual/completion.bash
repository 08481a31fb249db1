# Completion of shakerd and shakerctl in bash, from what --help lists: commands, options, the words of an option; else files.
# In zsh: autoload -U bashcompinit && bashcompinit, then source this file. fish reads the manual pages.
_shaker_completion() {
    local current=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD - 1]} words
    if [ "$COMP_CWORD" -eq 1 ]; then
        words=$("$1" --help 2>/dev/null | sed -nE '/^Commands:/,/^$/s/^  ([a-z]+) .*/\1/p; s/^ .*(--[a-z-]+).*/\1/p')
    else
        words=$("$1" "${COMP_WORDS[1]}" --help 2>/dev/null | sed -nE "s/^ .*$before ([a-z-]+(\|[a-z-]+)+)( .*)?$/\1/p" | tr '|' ' ')
        [ -n "$words" ] || words=$("$1" "${COMP_WORDS[1]}" --help 2>/dev/null | sed -nE 's/^ .*(--[a-z-]+).*/\1/p')
    fi
    COMPREPLY=($(compgen -W "$words" -- "$current"))
    [ ${#COMPREPLY[@]} -gt 0 ] || COMPREPLY=($(compgen -f -- "$current"))
}
complete -o filenames -F _shaker_completion shakerd shakerctl
