//! Every figure can be made, at reduced size.

#[test]
fn every_figure_makes_its_picture() {
    let folder = tempfile::tempdir().unwrap();
    for figure in lab::figure::all().unwrap() {
        let path = lab::figure::make(&figure, folder.path(), true).unwrap();
        let picture = image::open(&path).unwrap();
        assert!(picture.width() >= 200 && picture.height() >= 100, "{}", path.display());
    }
}
