//! What is written reads back the same, for documents of every shape.

mod support;

use aam::document::Encoding;
use aam::{Document, ReadOptions, WriteOptions, check, read, write};
use proptest::prelude::*;
use support::Choices;

fn back(document: &Document, options: &WriteOptions) -> Document {
    let bytes = write(document, options).unwrap_or_else(|error| panic!("{error}\n{document:#?}"));
    match read(&bytes, &ReadOptions::default()) {
        Ok(outcome) => outcome.document,
        Err(error) => panic!("{error}\n{}", String::from_utf8_lossy(&bytes)),
    }
}

/// Bit for bit, so that -0 is told from 0.
fn same(a: &Document, b: &Document) -> bool {
    format!("{a:?}") == format!("{b:?}")
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn written_documents_read_back(bytes in prop::collection::vec(any::<u8>(), 0..1500)) {
        let document = Choices(&bytes).document();
        for crlf in [false, true] {
            for encoding in [Encoding::Ascii, Encoding::Binary] {
                let options = WriteOptions { encoding: Some(encoding), crlf, digits: None };
                let read = back(&document, &options);
                prop_assert!(same(&read, &Document { encoding, ..document.clone() }), "{document:#?}\n{read:#?}");
            }
        }
    }

    #[test]
    fn writing_is_a_fixed_point(bytes in prop::collection::vec(any::<u8>(), 0..800)) {
        let document = Choices(&bytes).document();
        let options = WriteOptions::default();
        let once = write(&document, &options).expect("writable");
        let twice = write(&read(&once, &ReadOptions::default()).expect("readable").document, &options).expect("writable");
        prop_assert_eq!(once, twice);
    }

    #[test]
    fn fixed_digits_round_no_further_than_they_say(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        let mut document = Choices(&bytes).document();
        document.encoding = Encoding::Ascii;
        let read = back(&document, &WriteOptions { digits: Some(4), ..WriteOptions::default() });
        for (a, b) in document.objects().iter().zip(read.objects()) {
            for (x, y) in a.vertices.as_flattened().iter().zip(b.vertices.as_flattened()) {
                // Half a unit of the last digit, and half an ulp when the decimal is read back.
                let allowed = 0.5e-4 * 1.000_001 + f64::from(x.abs()) * 6e-8;
                prop_assert!((f64::from(*x) - f64::from(*y)).abs() <= allowed, "{x} became {y}");
            }
        }
    }

    /// No damage to a file panics, in reading, checking or writing again.
    #[test]
    fn damaged_files_never_panic(
        bytes in prop::collection::vec(any::<u8>(), 0..600),
        at in any::<prop::sample::Index>(),
        with in prop::collection::vec(any::<u8>(), 0..6),
        cut in any::<prop::sample::Index>(),
    ) {
        let document = Choices(&bytes).document();
        let mut file = write(&document, &WriteOptions::default()).expect("writable");
        let start = at.index(file.len());
        let end = (start + with.len()).min(file.len());
        file.splice(start..end, with);
        for file in [&file[..], &file[..cut.index(file.len() + 1)]] {
            if let Ok(outcome) = read(file, &ReadOptions::default()) {
                let _ = check(&outcome.document, Some((file, &outcome.places)));
                let again = write(&outcome.document, &WriteOptions::default());
                prop_assert!(again.is_ok(), "{again:?}");
            }
        }
    }
}

#[test]
fn truncation_at_every_byte_is_an_error_or_a_document() {
    let seed: Vec<u8> = (0..1400u32).map(|i| (i.wrapping_mul(2_654_435_761) >> 13) as u8).collect();
    for encoding in [Encoding::Ascii, Encoding::Binary] {
        let document = Choices(&seed).document();
        let options = WriteOptions { encoding: Some(encoding), ..WriteOptions::default() };
        let file = write(&document, &options).expect("writable");
        let complete = file.trim_ascii_end().len();
        for end in 0..complete {
            let outcome = read(&file[..end], &ReadOptions::default());
            // Before its end a file is whole only without its PHYSICS section; part of that word is left over with a warning.
            let head = file[..end].trim_ascii_end();
            let geometry = (0..7).any(|n| {
                head.strip_suffix(&b"PHYSICS"[..n]).is_some_and(|head| head.trim_ascii_end().ends_with(b"ENDGEOMETRY"))
            });
            assert_eq!(outcome.is_ok(), document.physics.is_some() && geometry, "cut at {end}: {outcome:?}");
        }
    }
}
