//! Where cards stand that nobody has placed: on none of those that are there.

use std::collections::{BTreeSet, HashMap};

use egui::{Pos2, Rect, pos2, vec2};

use super::free::free_place;
use super::layout::{self, COLUMN, Card};
use super::rows::WIDTH;
use super::{GraphItem, GraphView};
use crate::context::Context;
use crate::model::Target;

impl GraphView {
    /// Gives places to cards that have none, and moves those that have only just come to where they lie on nothing.
    pub(super) fn place(&mut self, cx: &Context<'_>, subjects: &[GraphItem<'_>]) {
        let ids: Vec<String> = subjects.iter().map(|subject| subject.id()).collect();
        let head = ids.first().cloned();
        // Of another material, or at the start, all cards come at once: where they stood is right then.
        let is_same = self.shown_of == head && !self.shown.is_empty();
        let has_place = |id: &String| self.places.contains_key(id);
        let is_new = |id: &String| !has_place(id) || is_same && !self.shown.contains(id);
        let new: Vec<usize> = (0..ids.len()).filter(|&i| is_new(&ids[i])).collect();
        let has_any = ids.iter().any(has_place);
        if !new.is_empty() {
            let cards = self.cards(cx, subjects, &ids);
            let arranged = layout::arrange(&cards, &frames(cx, subjects));
            if !has_any {
                let places = ids.iter().cloned().zip(arranged);
                self.places.extend(places);
            } else {
                self.place_new(cx, subjects, &cards, &arranged, &new);
            }
        }
        if !new.is_empty() || self.shown.len() != ids.len() || !is_same {
            self.shown = ids.into_iter().collect();
            self.shown_of = head;
        }
    }

    /// All cards with their heights and who reads them.
    fn cards<'i>(
        &mut self,
        cx: &Context<'_>,
        subjects: &[GraphItem<'_>],
        ids: &'i [String],
    ) -> Vec<Card<'i>> {
        let index = |subject: GraphItem<'_>| subjects.iter().position(|other| *other == subject);
        let mut cards: Vec<Card<'i>> = subjects
            .iter()
            .zip(ids)
            .map(|(&subject, id)| Card {
                id,
                height: self.rows(cx, subject).height,
                readers: Vec::new(),
            })
            .collect();
        for wire in &cx.model.wires {
            let reader = match &wire.target {
                Target::Parameter { node, .. } => GraphItem::Node(node),
                Target::Input { material, .. } | Target::Mask { material } => {
                    GraphItem::Material(material)
                }
            };
            if let (Some(source), Some(reader)) =
                (index(GraphItem::Node(&wire.source)), index(reader))
            {
                cards[source].readers.push(reader);
            }
        }
        for (reader, subject) in subjects.iter().enumerate() {
            let GraphItem::Material(material) = *subject else {
                continue;
            };
            for side in cx.model.sides(material).into_iter().flatten() {
                let side = index(GraphItem::Material(side));
                if let Some(side) = side.filter(|&side| side != reader) {
                    cards[side].readers.push(reader);
                }
            }
        }
        cards
    }

    /// Finds places for some cards among the others.
    fn place_new(
        &mut self,
        cx: &Context<'_>,
        subjects: &[GraphItem<'_>],
        cards: &[Card<'_>],
        arranged: &[Pos2],
        new: &[usize],
    ) {
        let new_set: BTreeSet<usize> = new.iter().copied().collect();
        let size = |i: usize| vec2(WIDTH, cards[i].height);
        let mut taken: HashMap<usize, Rect> = HashMap::new();
        for i in (0..cards.len()).filter(|i| !new_set.contains(i)) {
            if let Some(&place) = self.places.get(cards[i].id) {
                taken.insert(i, Rect::from_min_size(place, size(i)));
            }
        }
        let frames: Vec<(Rect, BTreeSet<usize>)> = frames(cx, subjects)
            .into_iter()
            .filter_map(|members| {
                let placed = members.iter().filter_map(|i| taken.get(i).copied());
                Some((super::frames::around(placed)?, members))
            })
            .collect();
        for &i in new {
            let wanted = self.places.get(cards[i].id).copied();
            let wanted = wanted.unwrap_or_else(|| beside(cards, &taken, i).unwrap_or(arranged[i]));
            let mut obstacles: Vec<Rect> = taken.values().copied().collect();
            let others = frames.iter().filter(|(_, members)| !members.contains(&i));
            obstacles.extend(others.map(|(rect, _)| *rect));
            let place = free_place(wanted, size(i), &obstacles);
            self.places.insert(cards[i].id.to_owned(), place);
            taken.insert(i, Rect::from_min_size(place, size(i)));
        }
    }
}

/// The cards of each frame, by their places in the list.
fn frames(cx: &Context<'_>, subjects: &[GraphItem<'_>]) -> Vec<BTreeSet<usize>> {
    let ids = subjects.iter().enumerate();
    let numbers: HashMap<String, usize> = ids.map(|(i, subject)| (subject.id(), i)).collect();
    let frames = cx.document.look().frames.iter();
    let members = frames.map(|frame| {
        let nodes = frame.nodes.iter().map(|node| GraphItem::Node(&node.value));
        let materials = frame.materials.iter();
        let materials = materials.map(|material| GraphItem::Material(&material.value));
        let members = nodes.chain(materials);
        members
            .filter_map(|member| numbers.get(&member.id()).copied())
            .collect()
    });
    members.collect()
}

/// To the left of what reads it, or to the right of what it reads, where that has a place.
fn beside(cards: &[Card<'_>], taken: &HashMap<usize, Rect>, i: usize) -> Option<Pos2> {
    let readers = cards[i].readers.iter().filter_map(|r| taken.get(r));
    let leftmost = readers.min_by(|a, b| a.left().total_cmp(&b.left()));
    if let Some(reader) = leftmost {
        return Some(pos2(reader.left() - COLUMN, reader.top()));
    }
    let sources = (0..cards.len()).filter(|&s| cards[s].readers.contains(&i));
    let sources = sources.filter_map(|s| taken.get(&s));
    let rightmost = sources.max_by(|a, b| a.left().total_cmp(&b.left()))?;
    Some(pos2(rightmost.left() + COLUMN, rightmost.top()))
}
