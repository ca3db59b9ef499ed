//! Invalid values of arguments.

use super::{folder, misuse, refuse};

const SEGMENT: &str = "segment square.obj --data D.npy --regions 2 --out out";
const SOLVE: &str = "solve square.obj --costs S.npy --lambda 1 --out out";

#[test]
fn numbers_out_of_range_are_refused() {
    let folder = folder();
    for (arguments, part) in [
        ("--gap -1", "--gap -1"),
        ("--gap nan", "--gap NaN"),
        ("--time-limit -1", "--time-limit -1"),
        ("--time-limit nan", "--time-limit NaN: must be a number of seconds from 0"),
        ("--time-limit 1e300", "--time-limit 1"),
        ("--stop-change -0.5", "--stop-change -0.5"),
        ("--stop-change nan", "--stop-change NaN"),
        ("--solver-option rho=2", "rho=2: must be"),
        ("--solver-option rho=nan", "rho=nan: must be"),
        ("--solver-option step-ratio=-1", "step-ratio=-1"),
        ("--solver-option steps=best", "local, diagonal, plain"),
        ("--solver-option rho", "must be key=value"),
        ("--solver-option rho=1 --solver-option rho=1", "given twice"),
        ("--solver-option epsilon=1", "unknown to chambolle-pock"),
        ("--solver fista --solver-option epsilon=0", "epsilon=0"),
        ("--solver fista --solver-option epsilon=inf", "epsilon=inf"),
        ("--solver fista --solver-option restart=sometimes", "restart=sometimes"),
        ("--solver fista --solver-option mass-metric=consistent", "mass-metric=consistent"),
        ("--solver fista --solver-option continuation=0", "continuation=0"),
        ("--solver projected-gradient --solver-option tau=0", "tau=0"),
        ("--solver projected-gradient --solver-option rho=1", "unknown to projected-gradient"),
    ] {
        refuse(&folder, &format!("{SOLVE} {arguments}"), &[part]);
        refuse(&folder, &format!("{SEGMENT} {arguments}"), &[part]);
    }
    for lambda in ["-1", "nan", "inf", "1e999"] {
        for line in [
            "solve square.obj --costs S.npy --out out",
            "segment square.obj --data D.npy --regions 2 --out out",
            "evaluate square.obj --costs S.npy --u U.npy",
        ] {
            refuse(&folder, &format!("{line} --lambda {lambda}"), &["lambda ="]);
        }
    }
    for epsilon in ["0", "-1", "nan", "inf"] {
        let line = "evaluate square.obj --costs S.npy --u U.npy --lambda 1 --epsilon";
        refuse(&folder, &format!("{line} {epsilon}"), &["epsilon ="]);
    }
    for (shape, part) in [
        ("cube:3", "is not a shape"),
        ("torus:400", "torus:400x250"),
        ("sphere:11", "must be 0 to 10"),
        ("grid:0x1", "at least 1x1"),
        ("grid:99999x99999", "at most 50000000"),
        ("grid:99999999999999999999x1", "at most 50000000"),
    ] {
        refuse(&folder, &format!("mesh generate {shape} --out out.ply"), &[shape, part]);
    }
    refuse(&folder, "mesh convert grid:1000x1000 --subdivide 8 --out out.ply", &["--subdivide 8"]);
}

#[test]
fn malformed_command_lines_exit_with_code_2() {
    let folder = folder();
    for regions in ["1", "0", "65", "256", "-2", "abc", "2.5", ""] {
        let line = format!("segment square.obj --data D.npy --out out --regions={regions}");
        misuse(&folder, &line, "--regions");
    }
    for arguments in [
        "--solver newton",
        "--mass heavy",
        "--threads 0",
        "--threads 9999999",
        "--max-iterations -1",
        "--max-iterations many",
        "--check-every 0",
        "--check-every 18446744073709551615",
        "--gap small",
        "--time-limit soon",
        "--seed -1",
        "--out again",
        "--frobnicate",
        "--no-preview=maybe",
    ] {
        let option = arguments.split([' ', '=']).next().unwrap();
        misuse(&folder, &format!("{SOLVE} {arguments}"), option);
        misuse(&folder, &format!("{SEGMENT} {arguments}"), option);
    }
    for (line, part) in [
        ("", "Usage"),
        ("frobnicate", "frobnicate"),
        ("mesh", "Usage"),
        ("mesh info", "<MESH>"),
        ("mesh info a.ply b.ply", "b.ply"),
        ("mesh convert square.obj", "--out"),
        ("mesh convert square.obj --out out.ply --subdivide 9", "--subdivide"),
        ("mesh generate --out out.ply", "<SHAPE>"),
        ("segment square.obj --out out", "--regions"),
        ("segment square.obj --regions 2", "--out"),
        (
            "segment square.obj --regions 2 --out out --data speed",
            "must be colors, texture, texture:IMAGE",
        ),
        ("segment square.obj --regions 2 --out out --data texture:", "must be colors"),
        ("segment square.obj --regions 2 --out out --model potts", "--model"),
        ("segment square.obj --regions 2 --out out --init best", "--init"),
        ("segment square.obj --regions 2 --out out --every 0", "--every"),
        ("segment square.obj --regions 2 --out out --normalize volume", "--normalize"),
        ("solve square.obj --costs S.npy --out out", "--lambda"),
        ("solve square.obj --lambda 1 --out out", "--costs"),
        (
            "solve square.obj --costs S.npy --lambda 1 --out out --init uniform --coarse-to-fine",
            "--coarse-to-fine",
        ),
        ("solve square.obj --costs S.npy --lambda 1 --out out --init=", "--init"),
        ("evaluate square.obj --costs S.npy --lambda 1", "--u"),
        (
            "evaluate square.obj --costs S.npy --lambda 1 --u U.npy --epsilon-mode both",
            "--epsilon-mode",
        ),
        ("operators square.obj", "--out"),
        ("completions cmd.exe", "cmd.exe"),
        ("solvers fista", "fista"),
    ] {
        misuse(&folder, line, part);
    }
}
