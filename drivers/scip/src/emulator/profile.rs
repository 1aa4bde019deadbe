//! The emulated models: identity, geometry, firmware.

/// Commands that a model has besides the common ones of SCIP 2.0, and the variant of its replies (scip2 sections 1, 6
/// and 10).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LaserGeneration {
    /// URG-04LX and relatives: distances only, one command per revolution.
    Urg,
    /// UTM-30LX on USB: `ME GE` (intensity) and `RT`; no `CR`, `HS`, `DB`.
    TopUrg,
    /// UST and UTM-30LX-EW on Ethernet, SCIP 2.2: also `ND NE HD HE` (multiple echoes), `RB`, `%ST`, `%SL`, `$IP`;
    /// answers `TM1` outside time adjust too.
    Ethernet,
}

/// One model and firmware (scip2 sections 1, 6, 9, 10 and 12).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LaserProfile {
    /// The set of commands.
    pub generation: LaserGeneration,
    /// `VEND` of `VV`.
    pub vendor: &'static str,
    /// `MODL` of `PP` and `II`.
    pub model: &'static str,
    /// `PROD` of `VV`.
    pub product: &'static str,
    /// `FIRM` of `VV`.
    pub firmware: String,
    /// `SERI` of `VV`.
    pub serial: String,
    /// For the SCIP 1.1 reply to `V`; `None` if the sensor starts in SCIP 2.0 and has no SCIP 1.1.
    pub scip1: Option<Scip1Lines>,
    /// `PROT` of `VV`.
    pub protocol: &'static str,
    /// Minimum distance, mm (`DMIN`).
    pub min_range_mm: u32,
    /// Maximum distance, mm (`DMAX`).
    pub max_range_mm: u32,
    /// Steps per revolution (`ARES`).
    pub steps_per_revolution: u32,
    /// First measured step (`AMIN`).
    pub first_step: u32,
    /// Last measured step (`AMAX`).
    pub last_step: u32,
    /// Step straight ahead (`AFRT`).
    pub front_step: u32,
    /// Highest step that can be requested.
    pub max_step: u32,
    /// Nominal speed, revolutions per minute (`SCAN`).
    pub speed_rpm: u32,
    /// What the sums of `KEY:value;` lines cover.
    pub keyed_sum: KeyedSumRule,
    /// `SBPS` of a sensor without a serial line; `None` if it has one and reports its bit rate.
    pub usb_only_text: Option<&'static str>,
    /// Whether the firmware has `HS` (from 3.2.00 on); older ones answer 0C.
    pub high_sensitivity: bool,
    /// Whether the firmware has `DB` (from 3.3.00 on, not all units); others answer 0E.
    pub failure_simulation: bool,
}

/// The lines of the SCIP 1.1 reply to `V` that differ from `VV`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Scip1Lines {
    /// The `FIRM:` line.
    pub firmware: &'static str,
    /// The `PROT:` line.
    pub protocol: &'static str,
    /// The `STAT:` line.
    pub status: &'static str,
}

/// What the sum of a `KEY:value;` line covers (scip2 section 3 has three variants).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum KeyedSumRule {
    /// Everything before the `;`, as in every byte log.
    BeforeSemicolon,
    /// The `;` too, which the vendor's library also accepts.
    WithSemicolon,
    /// Not from `<-` on, as reported of UTM-30LX firmware.
    BeforeComment,
}

impl LaserGeneration {
    /// `ME`, `GE` and `RT`.
    pub(super) fn has_intensity(self) -> bool {
        self != Self::Urg
    }

    /// SCIP 2.2, with more commands and other meanings of some statuses.
    pub(super) fn is_ethernet(self) -> bool {
        self == Self::Ethernet
    }
}

impl LaserProfile {
    /// URG-04LX H0706400 with firmware 3.1.04: USB and RS-232C, starts in SCIP 1.1 (scip2 section 12).
    pub fn urg_04lx() -> Self {
        Self {
            generation: LaserGeneration::Urg,
            vendor: "Hokuyo Automatic Co.,Ltd.",
            model: "URG-04LX(Hokuyo Automatic Co.,Ltd.)",
            product: "SOKUIKI Sensor URG-04LX",
            firmware: "3.1.04(02/Aug./2007)".to_owned(),
            serial: "H0706400".to_owned(),
            scip1: Some(Scip1Lines {
                firmware: "FIRM:3.1.04,07/08/02(20-4095[mm],240[deg],44-725[step],600[rpm])",
                protocol: "PROT:00003,(SCIP 1.0)",
                status: "STAT:FW Normal[FinalDist with shadow  ]",
            }),
            protocol: "SCIP 2.0",
            min_range_mm: 20,
            max_range_mm: 5600,
            steps_per_revolution: 1024,
            first_step: 44,
            last_step: 725,
            front_step: 384,
            max_step: 768,
            speed_rpm: 600,
            keyed_sum: KeyedSumRule::BeforeSemicolon,
            usb_only_text: None,
            high_sensitivity: false,
            failure_simulation: false,
        }
    }

    /// URG-04LX-UG01 H1510998 with firmware 3.4.03: USB only, starts in SCIP 2.0, has `HS` and `DB` (scip2 sections 1 and 12).
    /// Its `SBPS` text is that of other USB-only models.
    pub fn urg_04lx_ug01() -> Self {
        Self {
            model: "URG-04LX-UG01(Simple-URG)(Hokuyo Automatic Co.,Ltd.)",
            product: "SOKUIKI Sensor URG-04LX-UG01(Simple-URG)",
            firmware: "3.4.03(17/Dec./2012)".to_owned(),
            serial: "H1510998".to_owned(),
            scip1: None,
            usb_only_text: Some("USB Full Speed"),
            high_sensitivity: true,
            failure_simulation: true,
            ..Self::urg_04lx()
        }
    }

    /// UTM-30LX with firmware P.1.05: USB only, 40 revolutions per second, 1081 steps over 270 degrees (scip2 section 1). Its serial
    /// number and the date of its firmware are made up, since scip2 has none.
    pub fn utm_30lx() -> Self {
        Self {
            generation: LaserGeneration::TopUrg,
            model: "UTM-30LX(Hokuyo Automatic Co.,Ltd.)",
            product: "SOKUIKI Sensor TOP-URG UTM-30LX",
            firmware: "P.1.05(01/Apr./2008)".to_owned(),
            serial: "H0800001".to_owned(),
            scip1: None,
            min_range_mm: 23,
            max_range_mm: 60_000,
            steps_per_revolution: 1440,
            first_step: 0,
            last_step: 1080,
            front_step: 540,
            max_step: 1080,
            speed_rpm: 2400,
            usb_only_text: Some("USB Full Speed"),
            ..Self::urg_04lx()
        }
    }

    /// UST-20LX on TCP (scip2 section 10). For want of a full log its numbers are those of the UTM-30LX, its texts those of
    /// the simulator cited there; its serial number is made up.
    pub fn ust_20lx() -> Self {
        Self {
            generation: LaserGeneration::Ethernet,
            vendor: "Hokuyo Automatic Co., Ltd.",
            model: "UST-20LX",
            product: "UST-20LX",
            firmware: "1.1.0 (2011-09-30)".to_owned(),
            serial: "H1400001".to_owned(),
            protocol: "SCIP 2.2",
            usb_only_text: Some("Ethernet 100 [Mbps]"),
            ..Self::utm_30lx()
        }
    }

    /// The names for [`by_name`](Self::by_name).
    pub const NAMES: [&'static str; 4] = ["urg-04lx", "urg-04lx-ug01", "utm-30lx", "ust-20lx"];

    /// A profile by its name on a command line.
    pub fn by_name(name: &str) -> Option<Self> {
        match name {
            "urg-04lx" => Some(Self::urg_04lx()),
            "urg-04lx-ug01" => Some(Self::urg_04lx_ug01()),
            "utm-30lx" => Some(Self::utm_30lx()),
            "ust-20lx" => Some(Self::ust_20lx()),
            _ => None,
        }
    }
}

impl Default for LaserProfile {
    fn default() -> Self {
        Self::urg_04lx()
    }
}
