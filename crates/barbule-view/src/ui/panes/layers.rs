//! The layers of a stack, as they are written beside their picture.

use barbule::stack::Stack;

use super::words::digits;

/// A list names so many layers; what follows is counted.
const MOST: usize = 60;

/// A layer.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Layer {
    /// Its medium.
    pub(super) medium: String,
    /// Its thickness, nm.
    pub(super) thickness_nm: f64,
    /// The standard deviation of that between individuals, nm.
    pub(super) spread_nm: f64,
    /// The height of its upper boundary under the top, µm.
    pub(super) top_um: f64,
}

impl Layer {
    /// Its thickness and medium in words.
    pub(super) fn words(&self) -> String {
        let spread =
            if self.spread_nm > 0.0 { format!(" ± {}", digits(self.spread_nm)) } else { String::new() };
        format!("{}{spread} nm {}", digits(self.thickness_nm), self.medium)
    }
}

/// The layers from the top.
pub(super) fn of(stack: &Stack) -> Vec<Layer> {
    let mut top_um = 0.0;
    let each = stack.thickness_nm().iter().zip(stack.spread_nm()).enumerate();
    each.map(|(layer, (&thickness_nm, &spread_nm))| {
        let made = Layer { medium: stack.medium(layer + 1).to_owned(), thickness_nm, spread_nm, top_um };
        top_um -= 1e-3 * thickness_nm;
        made
    })
    .collect()
}

/// The layers from the top as lines of text.
pub(super) fn lines(layers: &[Layer]) -> Vec<String> {
    let mut lines: Vec<String> = layers
        .iter()
        .take(MOST)
        .enumerate()
        .map(|(k, layer)| format!("{}: {}", k + 1, layer.words()))
        .collect();
    if layers.len() > MOST {
        lines.push(format!("and {} more", layers.len() - MOST));
    }
    let all: f64 = layers.iter().map(|layer| layer.thickness_nm).sum();
    lines.push(format!("together {} nm", digits(all)));
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use barbule::material::Library;

    #[test]
    fn layers_are_those_of_the_stack_from_the_top() {
        let stack = Stack::parse("air/2*(melanin:99/keratin:100±5)/keratin", &Library::builtin()).unwrap();
        let layers = of(&stack);
        let words: Vec<String> = layers.iter().map(Layer::words).collect();
        assert_eq!(words, ["99 nm melanin", "100 ± 5 nm keratin", "99 nm melanin", "100 ± 5 nm keratin"]);
        assert!((layers[2].top_um + 0.199).abs() < 1e-12);
        assert_eq!(lines(&layers).last().unwrap(), "together 398 nm");
        let thick = Stack::parse("air/50*(melanin:99/keratin:100)/keratin", &Library::builtin()).unwrap();
        assert_eq!((lines(&of(&thick)).len(), lines(&of(&thick))[60].as_str()), (62, "and 40 more"));
    }
}
