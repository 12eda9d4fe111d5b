//! Compiles what calls MPI with the compiler of the MPI of this machine, `mpicc` or what `MPICC` names. Where there is none the program
//! is built all the same, and says so when it is called.

use std::process::Command;

fn main() {
    println!("cargo::rustc-check-cfg=cfg(mpi)");
    println!("cargo::rerun-if-changed=src/shim.c");
    for name in ["MPICC", "PATH"] {
        println!("cargo::rerun-if-env-changed={name}");
    }
    let compiler = std::env::var("MPICC").unwrap_or_else(|_| "mpicc".to_string());
    let Some(flags) = link_flags(&compiler) else {
        return;
    };
    cc::Build::new()
        .compiler(&compiler)
        .file("src/shim.c")
        .compile("dotyk_mpi_shim");
    println!("cargo::rustc-cfg=mpi");
    for flag in flags.split_whitespace() {
        if let Some(folder) = flag.strip_prefix("-L") {
            println!("cargo::rustc-link-search=native={folder}");
        } else if let Some(name) = flag.strip_prefix("-l") {
            println!("cargo::rustc-link-lib=dylib={name}");
        } else if flag.starts_with("-Wl,") {
            println!("cargo::rustc-link-arg={flag}");
        }
    }
}

/// What the compiler tells the linker, in the words of Open MPI or of MPICH.
fn link_flags(compiler: &str) -> Option<String> {
    ["--showme:link", "-link_info"].iter().find_map(|question| {
        let told = Command::new(compiler).arg(question).output().ok()?;
        let told = told.status.success().then_some(told.stdout)?;
        String::from_utf8(told).ok()
    })
}
