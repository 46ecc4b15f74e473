//! The meanings of the documents' symbols, and the assumptions of their formulas.
//!
//! A document uses each symbol in one sense, so the meanings are given once per document, in a [`Glossary`], and not
//! with every formula.

/// The symbols and assumptions of one group of formulas.
#[derive(Debug)]
pub struct Glossary {
    /// Prefix of the names of its formulas, before the dot.
    pub group: &'static str,
    /// The project's number of the document, if all formulas of the group come from one.
    pub document: Option<&'static str>,
    /// Symbols with their meanings. `ID/symbol` is the meaning in one formula only and takes precedence.
    pub symbols: &'static [(&'static str, &'static str)],
    /// Names of formulas with their assumptions; a name that ends in `*` stands for all with that prefix.
    pub assumptions: &'static [(&'static [&'static str], &'static str)],
}

impl Glossary {
    /// The meaning of `symbol` in the formula `id`.
    pub(super) fn meaning(&self, id: &str, symbol: &str) -> Option<&'static str> {
        let of = |key: &str| self.symbols.iter().find(|s| s.0 == key).map(|s| s.1);
        of(&format!("{id}/{symbol}")).or_else(|| of(symbol))
    }

    /// The assumptions of the formula `id`.
    pub(super) fn assumptions(&self, id: &str) -> impl Iterator<Item = &'static str> {
        self.assumptions
            .iter()
            .filter(move |a| a.0.iter().any(|pattern| stands_for(pattern, id)))
            .map(|a| a.1)
    }
}

fn stands_for(pattern: &str, id: &str) -> bool {
    pattern.strip_suffix('*').map_or(pattern == id, |beginning| id.starts_with(beginning))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::super::super::GLOSSARIES;
    use super::super::all;
    use super::*;

    #[test]
    fn every_symbol_of_every_formula_has_a_meaning() {
        let missing: BTreeSet<_> = all()
            .flat_map(|m| m.parameters.iter().map(move |p| (m, p.name)))
            .filter(|(m, name)| m.meaning(name).is_empty())
            .map(|(m, name)| format!("{}/{name}", m.id))
            .collect();
        assert!(missing.is_empty(), "{missing:?}");
    }

    #[test]
    fn nothing_is_explained_that_no_formula_has() {
        for glossary in GLOSSARIES {
            let keys: BTreeSet<_> = glossary.symbols.iter().map(|s| s.0).collect();
            assert_eq!(keys.len(), glossary.symbols.len(), "{}: a symbol stands twice", glossary.group);
            let group = || all().filter(|m| m.id.split('.').next() == Some(glossary.group));
            for (key, _) in glossary.symbols {
                let (only, symbol) = key.split_once('/').map_or((None, *key), |(id, s)| (Some(id), s));
                let used = group()
                    .filter(|m| only.is_none_or(|id| m.id == id))
                    .flat_map(|m| m.parameters)
                    .any(|p| p.name == symbol);
                assert!(used, "no formula of {} has {key}", glossary.group);
            }
            for pattern in glossary.assumptions.iter().flat_map(|a| a.0) {
                assert!(group().any(|m| stands_for(pattern, m.id)), "{pattern} stands for no formula");
            }
        }
    }
}
