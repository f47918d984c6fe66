//! Text from elsewhere (names of scenes, command lines, processors) as HTML.

use std::fmt;

/// Shows a text so that HTML, in an element as in an attribute, reads it as that text and nothing else.
pub struct Escaped<'a>(pub &'a str);

impl fmt::Display for Escaped<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for c in self.0.chars() {
            match c {
                '&' => f.write_str("&amp;")?,
                '<' => f.write_str("&lt;")?,
                '>' => f.write_str("&gt;")?,
                '"' => f.write_str("&quot;")?,
                '\'' => f.write_str("&#39;")?,
                // Not characters of HTML.
                c if c.is_control() && c != '\n' && c != '\t' => f.write_str("\u{fffd}")?,
                c => write!(f, "{c}")?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_gets_out() {
        let text = Escaped("<script a='b'>\"&\0</script>").to_string();
        assert_eq!(
            text,
            "&lt;script a=&#39;b&#39;&gt;&quot;&amp;\u{fffd}&lt;/script&gt;"
        );
    }
}
