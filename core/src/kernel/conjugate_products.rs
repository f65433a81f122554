//! The sum of products of two spectra, the innermost loop of the slope finder.

use multiversion::multiversion;

/// Complex numbers as two slices of one length: real and imaginary parts.
pub(crate) type Parts<'a> = (&'a [f32], &'a [f32]);

/// Adds conj(a)·b to the complex numbers `re` and `im`; these are at most as many as those of `a` and `b`.
pub(crate) fn add_conjugate_products(a: Parts<'_>, b: Parts<'_>, re: &mut [f32], im: &mut [f32]) {
    add(a.0, a.1, b.0, b.1, re, im);
}

#[multiversion(targets("x86_64+avx2+fma", "aarch64+neon"))]
fn add(a_re: &[f32], a_im: &[f32], b_re: &[f32], b_im: &[f32], re: &mut [f32], im: &mut [f32]) {
    let n = re.len();
    let (a_re, a_im, b_re, b_im, im) = (&a_re[..n], &a_im[..n], &b_re[..n], &b_im[..n], &mut im[..n]);
    for i in 0..n {
        re[i] += a_re[i] * b_re[i] + a_im[i] * b_im[i];
        im[i] += a_re[i] * b_im[i] - a_im[i] * b_re[i];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(a: [f32; 2], b: [f32; 2], sum: [f32; 2]) -> [f32; 2] {
        [sum[0] + a[0] * b[0] + a[1] * b[1], sum[1] + a[0] * b[1] - a[1] * b[0]]
    }

    #[test]
    fn whole_rows_are_the_definition_for_each_number() {
        let wave = |k: f32| (0..37).map(|i| (k * i as f32 + 0.3 * k).sin()).collect::<Vec<f32>>();
        let (a, b) = ((wave(0.7), wave(1.9)), (wave(0.4), wave(2.3)));
        let (mut re, mut im) = (wave(1.1), wave(0.2));
        let before = (re.clone(), im.clone());
        add_conjugate_products((&a.0, &a.1), (&b.0, &b.1), &mut re, &mut im);
        for i in 0..37 {
            let expected = plain([a.0[i], a.1[i]], [b.0[i], b.1[i]], [before.0[i], before.1[i]]);
            assert!((re[i] - expected[0]).abs() < 1e-6 && (im[i] - expected[1]).abs() < 1e-6, "{i}");
        }
    }
}
