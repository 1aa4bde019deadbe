//! The synopsis of a manual page: every option with the name of its value, which the generator leaves out.

use clap::{Arg, ArgAction, Command};

/// The command, with the synopsis of itself and of all its commands set.
pub(crate) fn with_synopses(mut command: Command) -> Command {
    command.build();
    set_synopses(command)
}

fn set_synopses(command: Command) -> Command {
    let text = synopsis(&command);
    command.override_usage(text).mut_subcommands(set_synopses)
}

/// `patrold visit [--config FILE] [--json] NAME`.
fn synopsis(command: &Command) -> String {
    let name = command
        .get_bin_name()
        .unwrap_or_else(|| command.get_name())
        .to_owned();
    let shown = || command.get_arguments().filter(|arg| !arg.is_hide_set());
    let options = shown().filter(|arg| !arg.is_positional()).map(option);
    let positionals = shown().filter(|arg| arg.is_positional()).map(|arg| {
        let value = values(arg) + repeated(arg);
        in_brackets(arg, value)
    });
    let inner = command.has_subcommands().then(|| {
        let required = command.is_subcommand_required_set();
        if required { "COMMAND" } else { "[COMMAND]" }.to_owned()
    });
    let parts: Vec<String> = std::iter::once(name)
        .chain(options)
        .chain(positionals)
        .chain(inner)
        .collect();
    parts.join(" ")
}

fn option(arg: &Arg) -> String {
    let long = arg.get_long().map(|long| format!("--{long}"));
    let short = arg.get_short().map(|short| format!("-{short}"));
    let names: Vec<String> = short.into_iter().chain(long).collect();
    let mut text = names.join("|");
    if arg.get_action().takes_values() {
        text = format!("{text} {}", values(arg));
    }
    in_brackets(arg, text) + repeated(arg)
}

fn values(arg: &Arg) -> String {
    match arg.get_value_names() {
        Some(names) => names
            .iter()
            .map(|name| name.as_str())
            .collect::<Vec<_>>()
            .join(" "),
        None => arg.get_id().as_str().to_uppercase(),
    }
}

fn in_brackets(arg: &Arg, text: String) -> String {
    if arg.is_required_set() {
        text
    } else {
        format!("[{text}]")
    }
}

/// For what may be given several times.
fn repeated(arg: &Arg) -> &'static str {
    let values = arg.get_num_args().map_or(1, |range| range.max_values());
    let appends = matches!(arg.get_action(), ArgAction::Append | ArgAction::Count);
    if appends || values > values_named(arg) {
        "..."
    } else {
        ""
    }
}

fn values_named(arg: &Arg) -> usize {
    arg.get_value_names().map_or(1, <[_]>::len)
}

#[cfg(test)]
mod tests {
    use super::with_synopses;
    use clap::{Arg, ArgAction, Command};

    #[test]
    fn every_option_has_the_name_of_its_value() {
        let command = Command::new("p").subcommand(
            Command::new("see")
                .arg(
                    Arg::new("config")
                        .long("config")
                        .short('c')
                        .value_name("FILE"),
                )
                .arg(Arg::new("json").long("json").action(ArgAction::SetTrue))
                .arg(
                    Arg::new("at")
                        .long("at")
                        .num_args(2)
                        .value_names(["X", "Y"])
                        .required(true),
                )
                .arg(Arg::new("hidden").long("hidden").hide(true))
                .arg(Arg::new("name").value_name("NAME").required(true))
                .arg(Arg::new("more").num_args(0..)),
        );
        let built = with_synopses(command);
        let see = built.find_subcommand("see").expect("there");
        let usage = see.get_overridden_usage().expect("set").to_string();
        assert_eq!(
            usage,
            "p see [-c|--config FILE] [--json] --at X Y [-h|--help] NAME [MORE...]"
        );
    }
}
