//! What the screen shows, by the shader and by the renderer.

use barbule_appearance::render::tone::shown;
use barbule_appearance::scene::description::ToneWord;
use barbule_base::math::rng::Stream;
use barbule_view::gpu::{Question, Shader};

use crate::questions::Asking;

/// An eighth of a step of eight bits: halving the chroma twelve times ends within 2.4e-4, on either side of the gamut's edge.
const TONE_ERROR: f64 = 5e-4;

/// Colours over sixteen stops, some outside sRGB.
#[test]
fn the_shader_shows_what_the_renderer_shows() {
    for asking in Asking::all(Shader::Tone) {
        let mut stream = Stream::new(5, &[]);
        let mut questions = Vec::new();
        for k in 0..400 {
            let scale = 2.0_f64.powf(stream.uniform(-8.0, 8.0));
            let rgb = [0; 3].map(|_| (scale * stream.uniform(-0.1, 1.0)) as f32);
            questions.push(Question::Tone { rgb, is_film: k % 2 == 0 });
        }
        questions.extend([0.0, 0.18, 0.6, 1.0, 30.0].map(|v| Question::Tone { rgb: [v; 3], is_film: true }));
        let mut worst = 0.0_f64;
        for (question, answer) in questions.iter().zip(asking.ask_bound(&[], &questions)) {
            let Question::Tone { rgb, is_film } = question else { continue };
            let tone = if *is_film { ToneWord::Filmic } else { ToneWord::Plain };
            for (expected, found) in shown(tone, rgb.map(f64::from)).into_iter().zip(answer) {
                worst = worst.max((expected - found).abs());
            }
        }
        println!("{}: {worst:.1e}", asking.gpu);
        assert!(worst < TONE_ERROR, "{worst}");
    }
}
