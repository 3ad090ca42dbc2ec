//! Writers of XML and of HTML whose texts and attributes are escaped.

pub mod html;
pub mod xml;
