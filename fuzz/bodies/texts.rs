//! Parsers of fault specifications and emulator options. A fault error is one line.

use patrold_sim::emulator::EmulatedFault;

pub(crate) fn run(data: &[u8]) {
    let text = String::from_utf8_lossy(data);
    for line in text.lines() {
        if let Err(error) = line.parse::<EmulatedFault>() {
            assert!(!error.to_string().contains('\n'), "{error}");
        }
        let _ = scip::emulator::LaserOptions::default().set(line);
        let _ = ptu::emulator::HeadOptions::default().set(line);
    }
}

pub(crate) fn seeds() -> Vec<Vec<u8>> {
    let laser = scip::emulator::LaserFault::kinds()
        .map(|kind| format!("laser.{kind}:at=1,for=2.5,count=3"));
    let head =
        ptu::emulator::HeadFaultKind::kinds().map(|kind| format!("ptu.{kind}:at=1s,for=300ms"));
    let others = [
        "laser.unplug:at=1,for=2,as=/dev/x,power=kept",
        "laser.verify:status=31\nlaser.timer-set:to=16777\nptu.event:which=T,within=3,count=2",
        "profile=ust-20lx\nlink=57600\nmodel=d46-70\nlatency=1/2\nmoving-to=3/-4",
    ];
    let others = others.map(str::to_owned);
    laser
        .chain(head)
        .chain(others)
        .map(String::into_bytes)
        .collect()
}
