//! Attributes for tests that need software or data that is not on every machine.
//!
//! Where it is missing, the test is compiled with `#[ignore = "…"]`, so that the test runner lists the tests that did
//! not run, with the reason. An attribute stands above `#[test]`. It checks while the test program is compiled: after
//! installing the missing thing, touch a file of the test program, or run ignored tests with `cargo test --
//! --include-ignored`.

use proc_macro::{Delimiter, Group, Ident, Literal, Punct, Spacing, Span, TokenStream, TokenTree};
use std::{path::PathBuf, process::Command};

/// Ignores the test where one of the named files or folders of the real input is missing.
///
/// The real input is in the folder that `BURSTSCOPE_SHARED` names, or else in `../shared` beside the checkout. With
/// `BURSTSCOPE_REQUIRE_SHARED=1` a missing one is a compile error.
#[proc_macro_attribute]
pub fn shared(paths: TokenStream, test: TokenStream) -> TokenStream {
    let root = shared_root();
    let is_missing = |path: &String| !root.as_ref().is_some_and(|root| root.join(path).exists());
    let missing: Vec<String> = paths.into_iter().filter_map(text).filter(is_missing).collect();
    let named = missing.join(" and ");
    if missing.is_empty() {
        with_ignore(None, test)
    } else if std::env::var_os("BURSTSCOPE_REQUIRE_SHARED").is_some_and(|value| value != "0" && !value.is_empty()) {
        error(&format!("{named} is not in {root:?}, and BURSTSCOPE_REQUIRE_SHARED says that no test may be ignored"))
    } else {
        with_ignore(Some(&format!("needs {named}, in ../shared or where BURSTSCOPE_SHARED says")), test)
    }
}

/// Ignores the test where the Python that `BURSTSCOPE_PYTHON` names (or else `python3`) has no pycolmap or no numpy.
#[proc_macro_attribute]
pub fn pycolmap(_: TokenStream, test: TokenStream) -> TokenStream {
    let python = std::env::var("BURSTSCOPE_PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let imported = Command::new(&python).args(["-c", "import pycolmap, numpy"]).output();
    let reason = format!("needs pycolmap and numpy, in {python} or the Python that BURSTSCOPE_PYTHON names");
    with_ignore((!imported.is_ok_and(|output| output.status.success())).then_some(&reason), test)
}

/// Ignores the test where the kernel has no Landlock, by which a thread gives up files.
#[proc_macro_attribute]
pub fn landlock(_: TokenStream, test: TokenStream) -> TokenStream {
    #[cfg(target_os = "linux")]
    let is_offered = {
        use landlock::{AccessFs, CompatLevel, Compatible, Ruleset, RulesetAttr};
        Ruleset::default().set_compatibility(CompatLevel::HardRequirement).handle_access(AccessFs::ReadFile).is_ok()
    };
    #[cfg(not(target_os = "linux"))]
    let is_offered = false;
    with_ignore((!is_offered).then_some(&"needs a kernel with Landlock".to_owned()), test)
}

/// Ignores the test where the named program is in no folder of `PATH`.
#[proc_macro_attribute]
pub fn program(name: TokenStream, test: TokenStream) -> TokenStream {
    let name: String = name.into_iter().filter_map(text).collect();
    let path = std::env::var_os("PATH").unwrap_or_default();
    let is_there = std::env::split_paths(&path).any(|folder| folder.join(&name).is_file());
    with_ignore((!is_there).then_some(&format!("needs the program {name}")), test)
}

/// Folder of the real input: that of `BURSTSCOPE_SHARED`, or `shared` beside the folder that holds `Cargo.lock`.
fn shared_root() -> Option<PathBuf> {
    if let Some(named) = std::env::var_os("BURSTSCOPE_SHARED") {
        return Some(named.into());
    }
    let package = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR")?);
    let checkout = package.ancestors().find(|folder| folder.join("Cargo.lock").exists())?;
    Some(checkout.parent()?.join("shared"))
}

/// Text of a string literal without escapes.
fn text(token: TokenTree) -> Option<String> {
    match token {
        TokenTree::Literal(literal) => Some(literal.to_string().trim_matches('"').to_owned()),
        _ => None,
    }
}

/// Code that reads the variables of the lookup. The compiler notes which ones `option_env!` reads, and compiles the
/// test program again when they change; it does not note what an attribute reads.
const VARIABLES: &str = "const _: [Option<&str>; 3] = [option_env!(\"BURSTSCOPE_SHARED\"), \
     option_env!(\"BURSTSCOPE_REQUIRE_SHARED\"), option_env!(\"BURSTSCOPE_PYTHON\")];";

/// Returns `test`, with `#[ignore = "reason"]` above it where there is a reason.
fn with_ignore(reason: Option<&String>, test: TokenStream) -> TokenStream {
    // Once `#[test]` is expanded, `#[ignore]` has no effect.
    if !test.to_string().replace(' ', "").contains("#[test]") {
        return error("this attribute stands above #[test]");
    }
    let mut out: TokenStream = VARIABLES.parse().expect("it is Rust");
    if let Some(reason) = reason {
        let ignore = [
            TokenTree::Ident(Ident::new("ignore", Span::call_site())),
            Punct::new('=', Spacing::Alone).into(),
            Literal::string(reason).into(),
        ];
        out.extend([
            TokenTree::Punct(Punct::new('#', Spacing::Alone)),
            Group::new(Delimiter::Bracket, ignore.into_iter().collect()).into(),
        ]);
    }
    out.extend(test);
    out
}

/// Compiler error at the attribute.
fn error(message: &str) -> TokenStream {
    format!("compile_error!({message:?});").parse().expect("it is Rust")
}
