//! A server of one folder's files, for this machine alone.

use std::{
    fs,
    io::{self, BufRead, BufReader, Write},
    net::{Ipv4Addr, TcpListener, TcpStream},
    path::{Component, Path, PathBuf},
    thread,
};

/// Longest request that is read.
const MAX_REQUEST_BYTES: u64 = 64 << 10;

/// Serves until the program is ended. `isolated` pages may share memory with their workers.
pub(crate) fn serve(folder: &Path, port: u16, isolated: bool) -> Result<(), String> {
    if !folder.join("index.html").is_file() {
        return Err(format!("{}: there is no page; build it first", folder.display()));
    }
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(|e| format!("port {port}: {e}"))?;
    let port = listener.local_addr().map_err(|e| e.to_string())?.port();
    println!("http://localhost:{port}/ shows the viewer; Ctrl-C ends it");
    for stream in listener.incoming().flatten() {
        let folder = folder.to_path_buf();
        // A browser that goes away is no reason to stop.
        thread::spawn(move || drop(answer(&folder, isolated, stream)));
    }
    Ok(())
}

/// Answers one request and closes.
fn answer(folder: &Path, isolated: bool, stream: TcpStream) -> io::Result<()> {
    let mut lines = BufReader::new(io::Read::take(&stream, MAX_REQUEST_BYTES)).lines();
    let request = lines.next().transpose()?.unwrap_or_default();
    // The rest of the request says nothing of interest, but is read so that it is not cut off.
    for line in lines {
        if line?.is_empty() {
            break;
        }
    }
    let mut words = request.split(' ');
    let (method, target) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
    let found = match method {
        "GET" | "HEAD" => file_of(folder, target).and_then(|path| Some((fs::read(&path).ok()?, path))),
        _ => None,
    };
    let (status, kind, body) = match found {
        Some((body, path)) => ("200 OK", kind_of(&path), body),
        None => ("404 Not Found", "text/plain", b"not here\n".to_vec()),
    };
    let isolation = match isolated {
        true => "Cross-Origin-Opener-Policy: same-origin\r\nCross-Origin-Embedder-Policy: require-corp\r\n",
        false => "",
    };
    let mut out = &stream;
    write!(
        out,
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nCache-Control: no-cache\r\n{isolation}Connection: close\r\n\r\n",
        body.len()
    )?;
    if method != "HEAD" {
        out.write_all(&body)?;
    }
    out.flush()
}

/// The file that a target stands for; `None` for what lies outside the folder.
fn file_of(folder: &Path, target: &str) -> Option<PathBuf> {
    let path = target.split(['?', '#']).next()?.strip_prefix('/')?;
    let path = Path::new(if path.is_empty() { "index.html" } else { path });
    path.components().all(|part| matches!(part, Component::Normal(_))).then(|| folder.join(path))
}

fn kind_of(path: &Path) -> &'static str {
    match path.extension().and_then(|ending| ending.to_str()) {
        Some("html") => "text/html; charset=utf-8",
        Some("js") => "text/javascript; charset=utf-8",
        Some("wasm") => "application/wasm",
        _ => "application/octet-stream",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    fn asked(folder: &Path, isolated: bool, request: &str) -> String {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).unwrap();
        let address = listener.local_addr().unwrap();
        let folder = folder.to_path_buf();
        let server = thread::spawn(move || answer(&folder, isolated, listener.accept().unwrap().0));
        let mut client = TcpStream::connect(address).unwrap();
        client.write_all(request.as_bytes()).unwrap();
        let mut told = String::new();
        client.read_to_string(&mut told).unwrap();
        server.join().unwrap().unwrap();
        told
    }

    #[test]
    fn files_of_the_folder_are_served_and_nothing_beside_it() {
        let dir = tempfile::tempdir().unwrap();
        let page = dir.path().join("page");
        fs::create_dir(&page).unwrap();
        fs::write(page.join("index.html"), "<p>here").unwrap();
        fs::write(dir.path().join("secret"), "beside").unwrap();
        let told = asked(&page, true, "GET /?scene=atrium HTTP/1.1\r\nHost: localhost\r\n\r\n");
        assert!(told.starts_with("HTTP/1.1 200") && told.ends_with("<p>here"), "{told}");
        assert!(told.contains("require-corp") && told.contains("text/html"), "{told}");
        for target in ["/../secret", "/gone", "//secret", "secret", "/pkg/../../secret"] {
            let told = asked(&page, false, &format!("GET {target} HTTP/1.1\r\n\r\n"));
            assert!(told.starts_with("HTTP/1.1 404") && !told.contains("require-corp"), "{target}: {told}");
        }
        assert!(asked(&page, true, "POST / HTTP/1.1\r\n\r\n").starts_with("HTTP/1.1 404"));
    }

    #[test]
    fn there_must_be_a_page() {
        let dir = tempfile::tempdir().unwrap();
        assert!(serve(dir.path(), 0, true).unwrap_err().contains("build it first"));
    }
}
