//! A service in a folder of its own with a scripted robot: what several tests need.

use link::Clock;
use nalgebra::Point3;
use patrold::config::{Settings, load};
use patrold::devices::Cancel;
use patrold::service::{Away, Connect, Control, Fault, Notes, Plan, Robot, ServiceError, serve};
use patrold::store::Level;
use patrold_engine::scan::Optics;
use patrold_engine::sweep::{Leg, Motion, Poll, RawScan, RawSweep, TimeSample};
use patrold_sim::world::{BeamFan, Lookaround, MountGeometry, NoiseOptions, Robot as Base, Scene};
use serde_json::{Value, json};
use std::io::{Read as _, Write as _};
use std::os::unix::net::UnixStream;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use tokio::sync::mpsc;

/// What the scripted robot does next.
#[derive(Debug, Clone, PartialEq)]
pub enum Act {
    /// Sweeps this shipped scene.
    See(&'static str),
    /// Gives the same scan again and again.
    Freeze,
    /// Fails with these words; whether the devices are lost.
    Fail(&'static str, bool),
    /// Sweeps until cancelled.
    Dawdle,
}

#[derive(Debug)]
pub struct Script {
    pub act: Act,
    /// Why connecting fails.
    pub absent: Option<&'static str>,
    /// What a look at the connected devices finds.
    pub unplugged: Option<&'static str>,
    pub connections: usize,
    pub sweeps: u64,
    /// Connections that were let go.
    pub parked: usize,
}

#[derive(Clone)]
pub struct Scripted(Arc<Mutex<Script>>);

impl Scripted {
    pub fn new(act: Act) -> Self {
        Self(Arc::new(Mutex::new(Script {
            act,
            absent: None,
            unplugged: None,
            connections: 0,
            sweeps: 0,
            parked: 0,
        })))
    }

    pub fn script(&self) -> MutexGuard<'_, Script> {
        self.0.lock().expect("no test panics while it holds this")
    }
}

impl Connect for Scripted {
    fn connect(
        &mut self,
        _settings: &Settings,
        notes: &Notes,
        _cancel: &Cancel,
    ) -> Result<Box<dyn Robot>, Away> {
        let mut script = self.script();
        script.connections += 1;
        match script.absent {
            Some(why) => Err(Away {
                reason: why.to_owned(),
                absent: true,
            }),
            None => {
                notes.say(Level::Info, "laser", "scripted laser answers".to_owned());
                Ok(Box::new(Connected(self.clone())))
            }
        }
    }
}

/// The scripted robot while it is connected.
struct Connected(Scripted);

impl Drop for Connected {
    fn drop(&mut self) {
        self.0.script().parked += 1;
    }
}

impl Robot for Connected {
    fn describe(&mut self) -> Value {
        json!({"laser": {"serial": "H0000000"}})
    }

    fn watch(&mut self) -> Result<(), Fault> {
        self.0.script().unplugged.map_or(Ok(()), |reason| {
            Err(Fault {
                reason: reason.to_owned(),
                lost: true,
            })
        })
    }

    fn sweep(
        &mut self,
        _settings: &Settings,
        _waypoint: Option<&str>,
        cancel: &Cancel,
    ) -> Result<RawSweep, Fault> {
        let (act, turn) = {
            let mut script = self.0.script();
            script.sweeps += 1;
            (script.act.clone(), script.sweeps)
        };
        match act {
            Act::See(scene) => Ok(swept(scene, turn)),
            Act::Freeze => {
                let mut raw = swept("storeroom.toml", turn);
                for leg in &mut raw.legs {
                    let first = leg.scans[0].values.clone();
                    for scan in &mut leg.scans {
                        scan.values.clone_from(&first);
                    }
                }
                Ok(raw)
            }
            Act::Fail(reason, lost) => Err(Fault {
                reason: reason.to_owned(),
                lost,
            }),
            Act::Dawdle => {
                while !cancel.is_cancelled() {
                    std::thread::sleep(Duration::from_millis(5));
                }
                Err(Fault {
                    reason: "cancelled".to_owned(),
                    lost: false,
                })
            }
        }
    }
}

const TILT_RAD_PER_STEP: f64 = 0.000_897_6;
const FROM_RAD: f64 = -0.61;
const TO_RAD: f64 = 0.44;
const LINE_RAD: f64 = 0.0087;
const PERIOD: Duration = Duration::from_millis(100);

/// What perfect devices would have given in a shipped scene; `turn` makes the noise of each sweep its own.
fn swept(scene: &str, turn: u64) -> RawSweep {
    let folder = patrold_test_support::workspace_root().join("config/scenes");
    let load = |file: &str| std::fs::read_to_string(folder.join(file)).map_err(|e| e.to_string());
    let scene = Scene::resolve(scene, &load).expect("a shipped scene");
    let mut around = Lookaround {
        world: Arc::new(scene.build(None).expect("builds")),
        robot: Base {
            pose: scene.map_from_base,
            mount: MountGeometry::default(),
        },
        fan: BeamFan::default(),
        noise: NoiseOptions::seeded(turn),
    };
    let speed_rad_s = LINE_RAD / PERIOD.as_secs_f64();
    let begin_s = 100.0;
    let lasts_s = (TO_RAD - FROM_RAD) / speed_rad_s + 0.4;
    let tilt_rad = move |at_s: f64| {
        let passed_s = (at_s - begin_s).clamp(0.0, lasts_s);
        FROM_RAD - 0.2 * speed_rad_s + speed_rad_s * passed_s
    };
    let lines = (lasts_s / PERIOD.as_secs_f64()) as u32;
    let mut scans = Vec::new();
    for line in 0..lines {
        let start = Duration::from_secs_f64(begin_s) + PERIOD * line;
        let mut values = vec![0; 769];
        let attitude = |at: Duration| (0.0, tilt_rad(at.as_secs_f64()));
        around.revolve(start, PERIOD, &attitude, &mut values);
        scans.push(RawScan {
            stamp_ms: start.as_millis() as u64,
            arrived_s: start.as_secs_f64() + 0.08,
            values: values[44..=725].to_vec(),
        });
    }
    let polls = (0..)
        .map(|i| begin_s - 0.5 + f64::from(i) / 60.0)
        .take_while(|at_s| *at_s < begin_s + lasts_s + 0.5)
        .map(|at_s| Poll {
            sent_s: at_s - 0.003,
            received_s: at_s + 0.003,
            tilt_steps: (tilt_rad(at_s) / TILT_RAD_PER_STEP).round() as i32,
        })
        .collect();
    let sample = |at_s: f64| TimeSample {
        sent_s: at_s - 0.0005,
        received_s: at_s + 0.0005,
        stamp_ms: (at_s * 1e3).round() as u64,
    };
    let leg = Leg {
        pan_rad: 0.0,
        motion: Motion::Tilting {
            speed_steps_s: speed_rad_s / TILT_RAD_PER_STEP,
        },
        scans,
        polls,
        time_samples: vec![sample(begin_s - 2.0), sample(begin_s + lasts_s + 2.0)],
    };
    RawSweep {
        optics: Optics {
            steps_per_turn: 1024,
            front_step: 384,
            first_step: 44,
            cluster: 1,
            dmin_mm: 20,
            dmax_mm: 5600,
            period_s: PERIOD.as_secs_f64(),
        },
        mount: Settings::defaults().mount.chain(),
        tilt_rad_per_step: TILT_RAD_PER_STEP,
        tilt_zero_rad: 0.0,
        tilt_low_rad: FROM_RAD,
        tilt_high_rad: TO_RAD,
        line_pitch_rad: LINE_RAD,
        time_offset_s: 0.0,
        tilt_backlash_rad: 0.0,
        legs: vec![leg],
    }
}

/// A running service.
pub struct House {
    pub dir: PathBuf,
    pub robot: Scripted,
    controls: mpsc::Sender<Control>,
    thread: JoinHandle<Result<(), ServiceError>>,
}

/// One HTTP answer.
#[derive(Debug)]
pub struct Answer {
    pub status: u16,
    pub head: String,
    pub body: Vec<u8>,
}

impl Answer {
    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.body).expect("JSON")
    }

    /// The one line of an error.
    pub fn error(&self) -> String {
        let text = self.json()["error"].as_str().expect("an error").to_owned();
        assert_eq!(text.lines().count(), 1, "{text}");
        text
    }
}

/// Writes the configuration of a service in `dir`, with `more` at its end.
pub fn configure(dir: &Path, more: &str) {
    let text = format!(
        "store.dir = {:?}\napi.socket = {:?}\nmount.xyz_m = [0.0, 0.0, 0.05]\n{more}",
        dir.join("store"),
        dir.join("patrold.sock")
    );
    std::fs::write(dir.join("patrold.toml"), text).expect("configuration written");
}

pub fn plan(dir: &Path, robot: &Scripted) -> Plan {
    let config = dir.join("patrold.toml");
    Plan {
        loaded: load(Some(&config), &[]).expect("valid configuration"),
        config: Some(config),
        clock: Clock::real(),
        connect: Box::new(robot.clone()),
        log: None,
    }
}

impl House {
    pub fn start(dir: &Path, robot: &Scripted) -> Self {
        Self::start_with(dir, robot, plan(dir, robot))
    }

    /// A service made of other parts.
    pub fn start_with(dir: &Path, robot: &Scripted, plan: Plan) -> Self {
        let (controls, receiver) = mpsc::channel(4);
        let thread = std::thread::spawn(move || {
            let runtime = tokio::runtime::Runtime::new().expect("runtime");
            let ended = runtime.block_on(serve(plan, receiver));
            runtime.shutdown_background();
            ended
        });
        let house = Self {
            dir: dir.to_owned(),
            robot: robot.clone(),
            controls,
            thread,
        };
        house.until("the socket listens", |house| house.socket().exists());
        house
    }

    pub fn socket(&self) -> PathBuf {
        self.dir.join("patrold.sock")
    }

    pub fn until(&self, what: &str, met: impl Fn(&Self) -> bool) {
        let patience = Instant::now() + Duration::from_secs(60);
        while !met(self) {
            assert!(Instant::now() < patience, "{what}: did not come");
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    pub fn control(&self, control: Control) {
        self.controls.blocking_send(control).expect("it runs");
    }

    pub fn ask(&self, method: &str, path: &str, body: &str) -> Answer {
        let mut stream = UnixStream::connect(self.socket()).expect("it listens");
        write!(
            stream,
            "{method} {path} HTTP/1.1\r\nhost: x\r\nconnection: close\r\n\
             content-type: application/json\r\ncontent-length: {}\r\n\r\n{body}",
            body.len()
        )
        .expect("asked");
        let mut bytes = Vec::new();
        stream.read_to_end(&mut bytes).expect("answered");
        let cut = bytes
            .windows(4)
            .position(|w| w == b"\r\n\r\n")
            .expect("a head");
        let head = String::from_utf8_lossy(&bytes[..cut]).into_owned();
        let status = head[9..12].parse().expect("a status");
        Answer {
            status,
            head,
            body: bytes[cut + 4..].to_vec(),
        }
    }

    pub fn at(&self, path: &str, waypoint: &str) -> Answer {
        self.ask("POST", path, &json!({"waypoint": waypoint}).to_string())
    }

    pub fn status(&self) -> Value {
        self.ask("GET", "/status", "").json()
    }

    /// A visit that is answered, under this act of the robot.
    pub fn visit(&self, act: Act) -> Value {
        self.robot.script().act = act;
        let answer = self.at("/visit", "hall");
        assert_eq!(answer.status, 200, "{}", answer.json());
        answer.json()
    }

    pub fn stop(self) -> Duration {
        let begun = Instant::now();
        self.control(Control::Stop);
        let ended = self.thread.join().expect("no panic");
        ended.expect("a good end");
        begun.elapsed()
    }
}

/// Number of points of a PLY, by reading it.
pub fn points(ply: &[u8]) -> Vec<Point3<f64>> {
    patrold_engine::formats::read_cloud(ply, Some("ply"))
        .expect("a PLY")
        .points
}
