//! How light is found and how right the picture has to be, as they are asked for.

use engine::settings::Method;

/// How right a picture has to be.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Accuracy {
    /// For a look at it.
    Draft,
    /// As far as one sees.
    Final,
    /// On average.
    Reference,
}

impl Accuracy {
    /// All of them.
    pub(crate) const ALL: [Self; 3] = [Self::Draft, Self::Final, Self::Reference];

    /// Its name on the command line.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Draft => "draft",
            Self::Final => "final",
            Self::Reference => "reference",
        }
    }

    /// How it is asked for.
    pub(crate) fn flag(self) -> &'static str {
        match self {
            Self::Draft => "--accuracy draft",
            Self::Final => "--accuracy final",
            Self::Reference => "--accuracy reference",
        }
    }

    /// How it is reached.
    pub(crate) fn method(self) -> Method {
        match self {
            Self::Draft => Method::Draft,
            Self::Final => Method::Cache,
            Self::Reference => Method::Path,
        }
    }
}

/// How a method is asked for.
pub(crate) fn method_flag(method: Method) -> &'static str {
    match method {
        Method::Path => "--method path",
        Method::Draft => "--method draft",
        Method::Cache => "--method cache",
        Method::Photons => "--method photons",
        Method::CachePhotons => "--method cache+photons",
    }
}
