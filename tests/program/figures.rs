//! Every figure can be made, at reduced size.

#[test]
fn every_figure_makes_its_picture() {
    let folder = tempfile::tempdir().unwrap();
    for mut figure in lab::figure::all().unwrap() {
        // Pictures of shapes in space take a second each: two of a figure are enough here.
        if figure.panels.iter().all(|panel| panel.command == "curvature") {
            figure.panels.truncate(2);
        }
        let path = lab::figure::make(&figure, folder.path(), true).unwrap();
        let picture = image::open(&path).unwrap();
        assert!(picture.width() >= 200 && picture.height() >= 100, "{}", path.display());
    }
}
