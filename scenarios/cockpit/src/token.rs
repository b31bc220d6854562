//! Secrets that let browsers in.

use rand::TryRng;
use rand::rngs::SysRng;

/// A secret of 128 bits, in hexadecimal digits.
#[derive(Clone)]
pub(crate) struct AccessToken(String);

impl AccessToken {
    /// A new one, from the operating system's random numbers.
    pub(crate) fn new() -> std::io::Result<Self> {
        let mut bytes = [0; 16];
        SysRng.try_fill_bytes(&mut bytes).map_err(std::io::Error::other)?;
        Ok(Self(bytes.iter().map(|byte| format!("{byte:02x}")).collect()))
    }

    /// Whether this text is the secret. The time that the comparison takes reveals nothing about it.
    pub(crate) fn is(&self, given: &str) -> bool {
        let differences = self.0.bytes().zip(given.bytes()).fold(0, |sum, (a, b)| sum | (a ^ b));
        self.0.len() == given.len() && differences == 0
    }

    pub(crate) fn text(&self) -> &str {
        &self.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_token_is_known_by_its_whole_text_only() {
        let [token, other] = [AccessToken::new().unwrap(), AccessToken::new().unwrap()];
        let text = token.text();
        assert_eq!(text.len(), 32);
        assert!(token.is(text) && !token.is(other.text()));
        for wrong in
            ["", &text[1..], &format!("{text}0"), &text.to_uppercase().replace(|c: char| c.is_ascii_digit(), "f")]
        {
            assert!(!token.is(wrong), "{wrong} for {text}");
        }
    }
}
