# Types the line $2 and a tab into an interactive zsh with the completion in folder $1; `offered` gets what is offered.
zmodload zsh/zpty
until_there() { repeat 400 { [[ -s $1 ]] && return; sleep 0.02; zpty -rt z _ } }
zpty z zsh -f -i
zpty -w z "PS1=; fpath=($1 \$fpath); autoload -Uz compinit; compinit -u -D; bindkey '^I' complete-word"
zpty -w z 'compadd() { local -a got; (( ${@[(I)-[OAD]]} )) || { builtin compadd -O got "$@"; print -rl -- $got >> offered }; builtin compadd "$@" }'
zpty -w z 'precmd() { print 1 > ready }'
until_there ready
sleep 0.1
zpty -n -w z "$2"$'\t'
zpty -n -w z $'\x15print END >> ended\n'
until_there ended
zpty -d z
