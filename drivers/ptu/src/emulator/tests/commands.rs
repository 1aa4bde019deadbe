//! Every command and its reply.

use super::{Host, options};
use crate::emulator::{HeadModel, HeadOptions, Supply};

/// Request, verbose reply, terse reply; in this order on one unit at rest at 0,0.
const TABLE: &[(&str, &str, &str)] = &[
    ("PP", "* Current Pan position is 0", "* 0"),
    ("tp", "* Current Tilt position is 0", "* 0"),
    ("PO", "* Target Pan position is 0", "* 0"),
    ("PN", "* Minimum Pan position is -3090", "* -3090"),
    ("PX", "* Maximum Pan position is 3090", "* 3090"),
    ("TN", "* Minimum Tilt position is -907", "* -907"),
    ("TX", "* Maximum Tilt position is 604", "* 604"),
    (
        "PR",
        "* 185.1428 seconds arc per Pan position",
        "* 185.1428",
    ),
    (
        "TR",
        "* 185.1428 seconds arc per Tilt position",
        "* 185.1428",
    ),
    ("PS", "* Target Pan speed is 1000 positions/sec", "* 1000"),
    ("PD", "* Current Pan speed is 0 positions/sec", "* 0"),
    ("PA", "* Pan acceleration is 2000 positions/sec^2", "* 2000"),
    (
        "TB",
        "* Current Tilt base speed is 1000 positions/sec",
        "* 1000",
    ),
    ("PU", "* Maximum Pan speed is 2902 positions/sec", "* 2902"),
    ("TL", "* Minimum Tilt speed is 31 positions/sec", "* 31"),
    ("PH", "* Pan in REGULAR hold power mode", "* REG"),
    ("PHL", "*", "*"),
    ("PH", "* Pan in LOW hold power mode", "* LOW"),
    ("THO", "*", "*"),
    ("TH", "* Tilt in OFF hold power mode", "* OFF"),
    ("THR", "*", "*"),
    ("PM", "* Pan in REGULAR move power mode", "* REG"),
    ("PMH", "*", "*"),
    ("PM", "* Pan in HIGH move power mode", "* HIGH"),
    ("TML", "*", "*"),
    ("TM", "* Tilt in LOW move power mode", "* LOW"),
    (
        "L",
        "* Limit bounds are ENABLED (soft limits enabled)",
        "* Limit bounds are ENABLED (soft limits enabled)",
    ),
    ("LD", "*", "*"),
    (
        "L",
        "* Limit bounds are DISABLED (hard limits only: use care)",
        "* Limit bounds are DISABLED (hard limits only: use care)",
    ),
    ("LE", "*", "*"),
    ("F", "* ASCII verbose mode", "* ASCII terse mode"),
    (
        "C",
        "* independent (default) speed control mode",
        "* independent (default) speed control mode",
    ),
    ("S", "*", "*"),
    ("I", "*", "*"),
    ("A", "*", "*"),
    ("H", "*", "*"),
    ("HP", "*", "*"),
    ("HT", "*", "*"),
    ("RD", "*", "*"),
    ("RP", "*", "*"),
    ("RT", "*", "*"),
    ("RE", "*", "*"),
    ("MQ", "* Monitor mode at power up is DISABLED", "* D"),
    ("ME", "*", "*"),
    ("MQ", "* Monitor mode at power up is ENABLED", "* E"),
    ("MD", "*", "*"),
    ("WP", "* Pan in HALF step mode", "* H"),
    ("WTE", "*", "*"),
    ("WT", "* Tilt in EIGHTH step mode", "* E"),
    ("WTH", "*", "*"),
    ("U", "* Unit ID is 0", "* 0"),
    ("O", "* Input 24 VDC @ 86 degF", "* 24.0,86,90,88"),
    ("XS3", "*", "*"),
    ("XG3", "*", "*"),
    ("XC3", "*", "*"),
    ("XG3", "! Preset not set", "! Preset not set"),
    ("XS33", "! Illegal command", "! Illegal command"),
    ("DS", "*", "*"),
    ("DR", "*", "*"),
    ("PS97", "*", "*"),
    ("PS", "* Target Pan speed is 97 positions/sec", "* 97"),
    ("PD3", "*", "*"),
    ("PS", "* Target Pan speed is 100 positions/sec", "* 100"),
    (
        "PS2903",
        "! Pan speed cannot exceed 2902 positions/sec",
        "! Pan speed cannot exceed 2902 positions/sec",
    ),
    (
        "PS30",
        "! Pan speed cannot be less than 31 positions/sec",
        "! Pan speed cannot be less than 31 positions/sec",
    ),
    (
        "PD-90",
        "! Pan speed cannot be less than 31 positions/sec",
        "! Pan speed cannot be less than 31 positions/sec",
    ),
    (
        "PL30",
        "! Motor speed cannot be less than 31 pos/sec",
        "! Motor speed cannot be less than 31 pos/sec",
    ),
    ("PL40", "*", "*"),
    ("PL31", "*", "*"),
    (
        "PA0",
        "! Acceleration table exceeded",
        "! Acceleration table exceeded",
    ),
    (
        "PP3091",
        "! Maximum allowable Pan position is 3090",
        "! Maximum allowable Pan position is 3090",
    ),
    (
        "TP-908",
        "! Minimum allowable Tilt position is -907",
        "! Minimum allowable Tilt position is -907",
    ),
    ("PO0", "*", "*"),
    (
        "TO605",
        "! Maximum allowable Tilt position is 604",
        "! Maximum allowable Tilt position is 604",
    ),
    ("PP0", "*", "*"),
    ("U128", "! Illegal unit ID", "! Illegal unit ID"),
    ("U0", "*", "*"),
    ("@(19200,0,F)", "*", "*"),
    ("@(9600,0,F)", "*", "*"),
    ("@(57600,0,F)", "! Illegal command", "! Illegal command"),
    ("PNU", "! Illegal command", "! Illegal command"),
    ("LU", "! Illegal command", "! Illegal command"),
    ("B", "! Illegal command", "! Illegal command"),
    ("BT", "! Illegal command", "! Illegal command"),
    ("IQ", "! Illegal command", "! Illegal command"),
    ("JE", "! Illegal command", "! Illegal command"),
    ("PN5", "! Illegal command", "! Illegal command"),
    ("PR5", "! Illegal command", "! Illegal command"),
    ("QQ", "! Illegal command", "! Illegal command"),
    ("CV", "*", "*"),
    (
        "C",
        "* pure velocity speed control mode",
        "* pure velocity speed control mode",
    ),
    ("PP5", "! Illegal command", "! Illegal command"),
    ("PS0", "*", "*"),
    ("TS0", "*", "*"),
    ("CI", "*", "*"),
    ("DF", "*", "*"),
];

#[test]
fn every_command_verbose_with_echo_and_terse() {
    let mut verbose_options = options();
    verbose_options.start.echo = true;
    verbose_options.start.verbose = true;
    let (mut verbose, mut terse) = (Host::new(verbose_options), Host::new(options()));
    for (request, in_words, short) in TABLE {
        assert_eq!(
            verbose.ask(&format!("{request} ")),
            format!("{request} {in_words}\r\n"),
            "verbose {request}"
        );
        assert_eq!(
            terse.ask(&format!("{request} ")),
            format!("{short}\r\n"),
            "terse {request}"
        );
    }
    assert_eq!(verbose.ask("E "), "E * Echoing ON\r\n");
    assert_eq!(
        terse.ask("E "),
        "E * Echoing ON\r\n",
        "DF restores the echo"
    );
    assert_eq!(verbose.head.eeprom_writes(), 1);
    let version = verbose.ask("V ");
    assert!(
        version.starts_with("V * Pan-Tilt Controller v2.12.1d1(C14/E)"),
        "{version}"
    );
    assert!(terse.ask("? ").lines().count() > 3);
}

#[test]
fn tables_take_their_time_and_want_rest() {
    let mut host = Host::new(options());
    for request in ["PB57 ", "TA3000 ", "PU4002 "] {
        assert_eq!(host.ask(request), "", "{request}");
        assert_eq!(host.wait(3.0), "*\r\n", "{request}");
    }
    assert_eq!(
        (host.number("PB "), host.number("TA "), host.number("PU ")),
        (57, 3000, 4002)
    );
    assert_eq!(host.ask("TP500 "), "*\r\n");
    for request in ["PB100 ", "PA1000 ", "PU3000 ", "DF "] {
        assert_eq!(
            host.ask(request),
            "! Illegal command while in motion\r\n",
            "{request}"
        );
    }
    host.wait(2.0);
    assert_eq!(host.number("PB "), 57, "a refused command changes nothing");
    assert_eq!(host.ask("PB58 PP "), "");
    assert_eq!(host.wait(3.0), "*\r\n* 0\r\n", "input waits meanwhile");
}

#[test]
fn e_series_extras() {
    let mut host = Host::new(HeadOptions {
        e_series: true,
        axis_reset_at_once: true,
        option_board: true,
        ..options()
    });
    assert_eq!(
        host.ask("PNU-100 TXU50 LU PP-101 TP50 "),
        "*\r\n*\r\n*\r\n! Minimum allowable Pan position is -100\r\n*\r\n"
    );
    assert_eq!(
        host.ask("L C IQ JE "),
        "* Limit bounds are ENABLED (user limits enabled)\r\n* Independent speed control mode\r\n* I\r\n*\r\n"
    );
    host.wait(1.0);
    assert_eq!(host.ask("B10,20,500,600 "), "*\r\n");
    assert_eq!(host.ask("B "), "* 10,20,500,600\r\n");
    assert_eq!(
        host.ask("B1,2,500,9600 PS "),
        "! Tilt speed cannot exceed 2902 positions/sec\r\n* 500\r\n"
    );
    assert!(host.ask("BT ").starts_with("* 10,20,500,600,"));
    host.send("RT ");
    assert_eq!(host.wait(20.0), "!T!T*\r\n");
    host.send("RP ");
    assert_eq!(host.wait(60.0), "!P!P*\r\n");
}

#[test]
fn network_selection_and_rescue() {
    let mut o = options();
    o.start.unit_id = 5;
    let mut host = Host::new(o);
    assert_eq!(host.ask("   V PP "), "", "a unit with another id is silent");
    assert_eq!(host.ask(" _0 U0 "), "*\r\n");
    assert_eq!(host.ask("U "), "* 0\r\n");
    assert_eq!(host.ask("_7 PP "), "");
    host.inject("event:which=T");
    assert_eq!(host.ask("U "), "");
    assert_eq!(
        host.ask("_0 PP "),
        "!T* 0\r\n",
        "what was printed meanwhile is kept"
    );
}

#[test]
fn models_steps_and_supply() {
    let mut host = Host::new(HeadOptions {
        byte_pacing: false,
        ..HeadOptions::for_model(HeadModel::D46_70)
    });
    assert_eq!(host.ask("ED FT PR "), "ED *\r\n*\r\n* 46.2857\r\n");
    host.head.set_supply(Supply {
        volts: 11.26,
        temperature_f: [100.0, 101.0, 102.0],
    });
    assert_eq!(host.ask("O "), "* 11.3,100,101,102\r\n");
    let mut host = Host::new(options());
    assert_eq!(
        host.ask("WTE TR "),
        "*\r\n* 185.1428\r\n",
        "in force after a reset"
    );
    host.send("R ");
    assert_eq!(host.wait(60.0), "!T!T!P!P*\r\n");
    assert_eq!(
        host.ask("TR TN TS PS "),
        "* 46.2857\r\n* -3628\r\n* 4000\r\n* 1000\r\n"
    );
    host.ask("TP400 ");
    host.wait(1.0);
    assert_eq!(host.truth(), (0.0, 100.0), "true positions are half steps");
}
