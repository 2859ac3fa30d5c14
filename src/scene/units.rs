//! Names of units.

/// Names of the units in which the scene's numbers are given. Nothing is converted: any consistent units will do.
#[derive(Debug, Clone, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
#[cfg_attr(feature = "scenes", derive(schemars::JsonSchema))]
pub struct Units {
    /// Unit of length; default "L".
    pub length: String,
    /// Unit of force; default "F".
    pub force: String,
}

impl Units {
    /// Unit of a dimension in the letters L and F, as `F/L`; units without them (`turns`, `s`) are their own.
    ///
    /// ```
    /// use supercoil::scene::Units;
    /// let units = Units { length: "nm".into(), force: "pN".into() };
    /// assert_eq!(units.of("F L"), "pN nm");
    /// ```
    pub fn of(&self, dimension: &str) -> String {
        let name = |letter: char| match letter {
            'L' => self.length.clone(),
            'F' => self.force.clone(),
            other => other.to_string(),
        };
        dimension.chars().map(name).collect()
    }

    /// Whether the units are nm and pN, for which thermal energy is known.
    pub(crate) fn are_molecular(&self) -> bool {
        (self.length.as_str(), self.force.as_str()) == ("nm", "pN")
    }
}

impl Default for Units {
    fn default() -> Self {
        Self { length: "L".into(), force: "F".into() }
    }
}
