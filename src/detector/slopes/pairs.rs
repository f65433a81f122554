//! The innermost loop of the slope finder: a product of two spectra.

use super::spectra::Spectrum;
use multiversion::multiversion;

/// Adds conj(a)·b to `sum`.
pub(super) fn add_products(a: &Spectrum, b: &Spectrum, sum: &mut Spectrum) {
    add(&a.re, &a.im, &b.re, &b.im, &mut sum.re, &mut sum.im);
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
