//! Files that other programs read: HEALPix maps (FITS), NumPy arrays, BSDF XML in the Klems basis.

use super::directions::Directions;
use crate::math::PI;
use crate::run::Outcome;
use crate::run::simulate::GroupResult;
use crate::sap::Half;
use crate::tally::klems;
use std::fmt::Write as _;

/// A HEALPix map as healpy reads it: a FITS file (version 4.0) with one binary table, RING order, one
/// column of doubles for each of `columns` (name, unit, one value a pixel).
pub fn fits(nside: u32, columns: &[(String, String, Vec<f64>)]) -> Vec<u8> {
    let pixels = 12 * u64::from(nside) * u64::from(nside);
    let mut out = header(&[
        card("SIMPLE", "T", "FITS standard"),
        card("BITPIX", "8", ""),
        card("NAXIS", "0", "no data here"),
        card("EXTEND", "T", "the map is in the extension"),
    ]);
    let mut cards = vec![
        card("XTENSION", "'BINTABLE'", "binary table"),
        card("BITPIX", "8", ""),
        card("NAXIS", "2", ""),
        card("NAXIS1", &(8 * columns.len()).to_string(), "bytes a row"),
        card("NAXIS2", &pixels.to_string(), "pixels"),
        card("PCOUNT", "0", ""),
        card("GCOUNT", "1", ""),
        card("TFIELDS", &columns.len().to_string(), ""),
    ];
    for (i, (name, unit, _)) in columns.iter().enumerate() {
        cards.push(card(&format!("TTYPE{}", i + 1), &format!("'{name:<8}'"), ""));
        cards.push(card(&format!("TFORM{}", i + 1), "'1D      '", ""));
        cards.push(card(&format!("TUNIT{}", i + 1), &format!("'{unit:<8}'"), ""));
    }
    cards.extend([
        card("PIXTYPE", "'HEALPIX '", ""),
        card("ORDERING", "'RING    '", ""),
        card("NSIDE", &nside.to_string(), ""),
        card("FIRSTPIX", "0", ""),
        card("LASTPIX", &(pixels - 1).to_string(), ""),
        card("INDXSCHM", "'IMPLICIT'", ""),
        card("OBJECT", "'FULLSKY '", ""),
    ]);
    out.extend(header(&cards));
    for pixel in 0..pixels as usize {
        for (_, _, values) in columns {
            out.extend(values[pixel].to_be_bytes());
        }
    }
    out.resize(out.len().div_ceil(2880) * 2880, 0);
    out
}

/// An 80-character card; text values come quoted, others stand right-aligned.
fn card(key: &str, value: &str, comment: &str) -> String {
    let value = if value.starts_with('\'') { format!("{value:<20}") } else { format!("{value:>20}") };
    let comment = if comment.is_empty() { String::new() } else { format!(" / {comment}") };
    format!("{key:<8}= {value}{comment}")
}

fn header(cards: &[String]) -> Vec<u8> {
    let mut text: String = cards.iter().map(|c| format!("{c:<80.80}")).collect();
    let _ = write!(text, "{:<80}", "END");
    let mut bytes = text.into_bytes();
    bytes.resize(bytes.len().div_ceil(2880) * 2880, b' ');
    bytes
}

/// A NumPy array of doubles (format 1.0, little-endian, C order).
pub fn npy(shape: &[usize], values: &[f64]) -> Vec<u8> {
    let sizes: String = shape.iter().map(|n| format!("{n}, ")).collect();
    let mut head = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({}), }}", sizes.trim_end());
    // Magic, version and length take 10 bytes; the whole head is a multiple of 64 and ends with a newline.
    let padded = (10 + head.len() + 1).div_ceil(64) * 64 - 10;
    head = format!("{head:<width$}\n", width = padded - 1);
    let mut out = b"\x93NUMPY\x01\x00".to_vec();
    out.extend((head.len() as u16).to_le_bytes());
    out.extend(head.as_bytes());
    values.iter().for_each(|v| out.extend(v.to_le_bytes()));
    out
}

/// Power that leaves through each pixel of the whole sphere, by half and wavelength: (value, error).
fn maps(d: &Directions, outcome: &Outcome, half: Half, npix: usize) -> Vec<(f64, Vec<f64>, Vec<f64>)> {
    let mut out = Vec::new();
    for (nm, group, lane) in outcome.wavelengths() {
        let (mut value, mut error) = (vec![0.0; npix], vec![0.0; npix]);
        for (p, (v, e)) in d.patches.iter().zip(d.powers(group, lane)) {
            if p.half == half {
                (value[p.pix], error[p.pix]) = (v, e);
            }
        }
        out.push((nm, value, error));
    }
    out
}

/// `angular_above.fits`, `.npy` and those below: name and bytes. The FITS maps hold, for each wavelength,
/// the share of the emitted power in each pixel and its standard error; the arrays have the shape
/// (wavelengths, 2, pixels) with the same numbers.
pub fn angular(d: &Directions, outcome: &Outcome, nside: u32) -> Vec<(String, Vec<u8>)> {
    let npix = 12 * (nside as usize) * (nside as usize);
    let mut out = Vec::new();
    for (half, name) in [(Half::Upper, "above"), (Half::Lower, "below")] {
        let maps = maps(d, outcome, half, npix);
        let mut columns = Vec::new();
        let mut values = Vec::new();
        for (nm, value, error) in &maps {
            values.extend_from_slice(value);
            values.extend_from_slice(error);
            columns.push((format!("P{nm}"), String::new(), value.clone()));
            columns.push((format!("E{nm}"), String::new(), error.clone()));
        }
        // FITS tables hold at most 999 columns.
        columns.truncate(998);
        out.push((format!("angular_{name}.fits"), fits(nside, &columns)));
        out.push((format!("angular_{name}.npy"), npy(&[maps.len(), 2, npix], &values)));
    }
    out
}

/// `bsdf.xml`: BRDF and BTDF of the light side in the full Klems basis (145 × 145), in the form of LBNL
/// WINDOW and Radiance; f in 1/sr, rows by outgoing, columns by incident patch. The bands "Visible" and
/// "Solar" hold the one wavelength of the run.
pub fn bsdf_xml(name: &str, group: &GroupResult) -> Option<String> {
    let layout = &group.layout;
    layout.detectors.klems.then_some(())?;
    let start = layout.detectors_start() + layout.detectors.klems_start();
    let basis = klems::PATCHES;
    let f = |incident: usize, out: usize| {
        let m = group.moments(start + incident * 2 * basis + out, 0);
        // Lambertian light: the patch's share of the incident power is its projected solid angle over π.
        let share = klems::projected(incident) / PI;
        m.mean() / (share * klems::projected(out % basis))
    };
    let block = |kind: &str, side: usize| {
        let mut data = String::new();
        for out in 0..basis {
            let row: Vec<String> =
                (0..basis).map(|incident| format!("{:.6e}", f(incident, side * basis + out))).collect();
            let _ = writeln!(data, "{}", row.join(", "));
        }
        format!(
            "<WavelengthDataBlock><WavelengthDataDirection>{kind}</WavelengthDataDirection>\
             <ColumnAngleBasis>LBNL/Klems Full</ColumnAngleBasis><RowAngleBasis>LBNL/Klems Full</RowAngleBasis>\
             <ScatteringDataType>{}</ScatteringDataType>\n<ScatteringData>\n{data}</ScatteringData>\
             </WavelengthDataBlock>",
            if side == 0 { "BRDF" } else { "BTDF" }
        )
    };
    let mut data = String::new();
    for band in ["Visible", "Solar"] {
        for (kind, side) in [("Transmission Front", 1), ("Reflection Front", 0)] {
            let _ = writeln!(
                data,
                "<WavelengthData><LayerNumber>System</LayerNumber><Wavelength unit=\"Integral\">{band}</Wavelength>\
                 <SourceSpectrum>CIE Illuminant D65 1nm.ssp</SourceSpectrum>\
                 <DetectorSpectrum>ASTM E308 1931 Y.dsp</DetectorSpectrum>{}</WavelengthData>",
                block(kind, side)
            );
        }
    }
    let name = quick_xml::escape::escape(name);
    Some(format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <WindowElement xmlns=\"http://windows.lbl.gov\" \
         xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\">\n\
         <WindowElementType>System</WindowElementType>\n<FileType>BSDF</FileType>\n<Optical><Layer>\n\
         <Material><Name>{name}</Name><Manufacturer>LightPro, {} nm</Manufacturer>\
         <DeviceType>Other</DeviceType></Material>\n\
         <DataDefinition><IncidentDataStructure>Columns</IncidentDataStructure></DataDefinition>\n{}\n{data}\
         </Layer></Optical>\n</WindowElement>\n",
        group.wavelengths[0],
        klems::angle_basis_xml()
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fits_files_are_made_of_blocks_and_big_endian_doubles() {
        let values: Vec<f64> = (0..12).map(|i| 0.1 * f64::from(i)).collect();
        let bytes = fits(1, &[("P550".into(), String::new(), values)]);
        assert_eq!(bytes.len(), 3 * 2880);
        assert!(bytes.starts_with(b"SIMPLE  =                    T / FITS standard"));
        let at = 2 * 2880 + 3 * 8;
        assert_eq!(f64::from_be_bytes(bytes[at..at + 8].try_into().unwrap()), 0.1 * 3.0);
    }

    #[test]
    fn arrays_begin_on_a_multiple_of_64() {
        let bytes = npy(&[2, 3], &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        assert_eq!((bytes.len() - 48) % 64, 0);
        assert!(String::from_utf8_lossy(&bytes[10..]).contains("'shape': (2, 3,)"));
        assert_eq!(f64::from_le_bytes(bytes[bytes.len() - 8..].try_into().unwrap()), 6.0);
    }
}
