// SPDX-License-Identifier: GPL-3.0-or-later
//! Chooses among functions of one name: by the fit of arguments, then by the expected result, then by rank.
//! Points, ranks and words are OSL's.

use super::call::Arg;
use super::checker::Checker;
use super::signature::{Formal, Signature};
use crate::source::Loc;
use crate::types::{Base, Type};
use std::collections::HashSet;

const EXACT: i32 = 100;
const INT_TO_FLOAT: i32 = 77;
const ARRAY: i32 = 44;
const SPACE: i32 = 32;
const TRIPLE: i32 = 27;
const CONVERT: i32 = 23;
const ANYTHING: i32 = 1;

struct Candidate {
    number: u32,
    points: i32,
    result: i32,
    /// The types that values in braces take.
    lists: Vec<Type>,
}

/// The order in which results are preferred when nothing else decides.
const fn rank(ty: Type) -> u8 {
    match ty.base {
        Base::Float => 0,
        Base::Int => 1,
        Base::Color => 2,
        Base::Vector => 3,
        Base::Point => 4,
        Base::Normal => 5,
        Base::Matrix => 6,
        Base::String => 7,
        Base::Closure => 8,
        Base::Struct(_) => 9,
        Base::Void | Base::Unknown => 10,
    }
}

/// Functions that a message lists.
const CANDIDATES: usize = 100;

impl Checker<'_> {
    fn points(&self, expected: Type, given: Type) -> i32 {
        if expected == given {
            return EXACT;
        }
        if expected.is_scalar() && given.is_scalar() {
            return if expected == Type::INT { 0 } else { INT_TO_FLOAT };
        }
        if expected.array < 0 && given.array > 0 && expected.element() == given.element() {
            return ARRAY;
        }
        if !expected.assignable_from(given, &self.program.structs) {
            return 0;
        }
        if expected.base.is_spatial() && given.base.is_spatial() {
            SPACE
        } else if expected.is_triple() && given.is_triple() {
            TRIPLE
        } else {
            CONVERT
        }
    }

    fn weigh(&mut self, signature: &Signature, args: &[Arg<'_>]) -> Option<(i32, Vec<Type>)> {
        let (mut points, mut lists, mut at) = (0, Vec::new(), 0);
        for formal in &signature.formals {
            match formal {
                Formal::Rest => {
                    points += ANYTHING * (args.len() - at.min(args.len())) as i32;
                    return Some((points, lists));
                }
                Formal::Pairs => {
                    if let Some(arg) = args.get(at) {
                        if arg.ty() != Type::STRING || at + 1 >= args.len() {
                            return None;
                        }
                        points += ANYTHING * (args.len() - at) as i32;
                    }
                    return Some((points, lists));
                }
                Formal::Any | Formal::AnyArray => {
                    let array = args.get(at)?.ty().is_array();
                    if array != (*formal == Formal::AnyArray) {
                        return None;
                    }
                    points += ANYTHING;
                }
                Formal::Is(expected) => {
                    let given = match args.get(at)? {
                        Arg::Checked(e) => e.ty,
                        Arg::Braces(e) => {
                            self.mute += 1;
                            let made = self.braces(e, *expected, false, true);
                            self.mute -= 1;
                            let ty = made?.ty;
                            lists.push(ty);
                            ty
                        }
                    };
                    match self.points(*expected, given) {
                        0 => return None,
                        more => points += more,
                    }
                }
            }
            at += 1;
        }
        (at == args.len()).then_some((points, lists))
    }

    /// Whether `trace` can give a colour.
    fn has_radiance(&self) -> bool {
        !self.options.strict
    }

    fn describe(&self, number: u32) -> String {
        let signature = &self.signatures[number as usize];
        let position =
            signature.loc.map_or(String::new(), |loc| format!("{}:{}\t", self.sources.name(loc), loc.line));
        let structs = &self.program.structs;
        format!(
            "    {position}{} {} ({})\n",
            signature.returns.display(structs),
            signature.name,
            signature.list(structs)
        )
    }

    fn call_text(&self, what: &str, name: &str, args: &[Arg<'_>], candidates: bool) -> String {
        let names: Vec<String> = args
            .iter()
            .map(|arg| match arg {
                Arg::Braces(_) => "initializer-list".to_owned(),
                Arg::Checked(e) => self.show(e.ty),
            })
            .collect();
        let end = if candidates { "\n  Candidates are:" } else { "" };
        format!("{what} '{name} ({})'{end}\n", names.join(", "))
    }

    /// The function to call; none, with a message, if none fits or several structs could be the result.
    pub(super) fn choose(&mut self, name: &str, args: &[Arg<'_>], expected: Type, loc: Loc) -> Option<u32> {
        let all = self.overloads(name);
        let mut scores_seen = HashSet::new();
        let mut best: Vec<Candidate> = Vec::new();
        if self.comparisons.is_spent() {
            return None;
        }
        if self.comparisons.spend(all.len()).is_none() {
            self.error(loc, self.comparisons.to_string());
            return None;
        }
        for &number in &all {
            let signature = self.signatures[number as usize].clone();
            if !scores_seen.insert((signature.returns, signature.formals.clone())) {
                continue;
            }
            // Radiance along a ray is requested only where a colour is expected; elsewhere `trace` is OSL's
            // hit or miss.
            if name == "trace"
                && signature.user.is_none()
                && (signature.returns == Type::COLOR) != (expected == Type::COLOR && self.has_radiance())
            {
                continue;
            }
            let Some((points, lists)) = self.weigh(&signature, args) else { continue };
            let highest = best.first().map_or(0, |c| c.points);
            if points < highest {
                continue;
            }
            if points != highest {
                best.clear();
            }
            let result = self.points(expected, signature.returns);
            best.push(Candidate { number, points, result, lists });
        }
        match best.len() {
            0 => {
                let known = !all.is_empty();
                let mut message = self.call_text("No matching function call to", name, args, known);
                for &number in all.iter().take(CANDIDATES) {
                    message.push_str(&self.describe(number));
                }
                if all.len() > CANDIDATES {
                    message.push_str(&format!("    and {} more\n", all.len() - CANDIDATES));
                }
                self.error(loc, message);
                None
            }
            1 => Some(best[0].number),
            _ => self.decide(best, name, args, loc),
        }
    }

    fn decide(&mut self, mut best: Vec<Candidate>, name: &str, args: &[Arg<'_>], loc: Loc) -> Option<u32> {
        let highest = best.iter().map(|c| c.result).max().unwrap_or(0);
        let mut winners = best.iter().filter(|c| c.result == highest);
        if let (Some(only), None) = (winners.next(), winners.next()) {
            return Some(only.number);
        }
        best.sort_by_key(|c| rank(self.signatures[c.number as usize].returns));
        let structs =
            best.iter().filter(|c| self.signatures[c.number as usize].returns.struct_id().is_some()).count();
        let same_lists = best.windows(2).all(|pair| pair[0].lists == pair[1].lists);
        if structs > 1 || !same_lists {
            let mut message = self.call_text("Ambiguous call to", name, args, true);
            for candidate in &best {
                message.push_str(&self.describe(candidate.number));
            }
            self.error_help(
                loc,
                message,
                "give the type of the result, as in (float) f(...), or those of the arguments".to_owned(),
            );
            return None;
        }
        let mut message = self.call_text("Ambiguous call to", name, args, false);
        message.push_str("  Chosen function is:\n");
        message.push_str(&self.describe(best[0].number));
        message.push_str("  Other candidates are:\n");
        for candidate in &best[1..] {
            message.push_str(&self.describe(candidate.number));
        }
        self.warning(loc, message);
        Some(best[0].number)
    }
}
