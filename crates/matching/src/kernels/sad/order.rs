//! What was found in stripes, in the order of the columns.

use super::memory::{Indices, Sad};
use super::{OUT, either, group, group_mut};
use crate::kernels::stripes::{LANES, Layout};

/// Right columns lie in several places, as many disparities as there are: gathers the winners of them all
/// in the last one, where the smaller indices are already.
#[inline(always)]
pub(super) fn gather_right<const MANY: bool>(sad: &mut Sad, layout: &Layout) {
    let length = layout.left();
    let (least, Indices { low, high }) = (&mut sad.right_least, &mut sad.right);
    // The last lane has no next one.
    let mut nothing = [0; LANES];
    nothing[LANES - 1] = OUT;
    for at in (0..least.len() - length).step_by(LANES) {
        // Further on stands what is in the next lane here.
        let (here, further) = least.split_at_mut(at + length);
        let (costs, least) = (group(here, at + 1), group_mut(further, 0));
        if MANY {
            let (here, further) = high.split_at_mut(at + length);
            take_of_lesser(costs, &nothing, least, group(here, at + 1), group_mut(further, 0));
        }
        let (here, further) = low.split_at_mut(at + length);
        take_of_lesser(costs, &nothing, least, group(here, at + 1), group_mut(further, 0));
        lower(costs, &nothing, least);
    }
}

/// Lowers least sums to others that are less.
#[inline(always)]
fn lower(costs: &[u8; LANES], nothing: &[u8; LANES], least: &mut [u8; LANES]) {
    for l in 0..LANES {
        least[l] = least[l].min(costs[l] | nothing[l]);
    }
}

/// Takes the numbers of sums that are less than the least ones so far.
#[inline(always)]
fn take_of_lesser(
    costs: &[u8; LANES],
    nothing: &[u8; LANES],
    least: &[u8; LANES],
    others: &[u8; LANES],
    numbers: &mut [u8; LANES],
) {
    for l in 0..LANES {
        numbers[l] = either((costs[l] | nothing[l]) < least[l], others[l], numbers[l]);
    }
}

/// Puts what won in the order of the columns.
#[inline(always)]
pub(super) fn tell<const MANY: bool>(sad: &mut Sad, layout: &Layout) {
    let Sad { winners, row, .. } = sad;
    layout.gather(&sad.least, &mut winners.least);
    layout.gather(&sad.before, &mut winners.before);
    layout.gather(&sad.after, &mut winners.after);
    tell_indices::<MANY>(&sad.left.low, &sad.left.high, layout, row, &mut winners.index);
    // Those before the last vectors of right columns are in the first lane alone.
    let alone = layout.shift(0);
    let (first, others) = winners.right_index.split_at_mut(alone);
    let Indices { low, high } = &sad.right;
    for (index, place) in first.iter_mut().zip((0..).step_by(LANES)) {
        *index = u16::from_le_bytes([low[place], high[place]]);
    }
    tell_indices::<MANY>(&low[alone * LANES..], &high[alone * LANES..], layout, row, others);
}

/// Puts indices in the order of the columns, by way of a row of bytes.
#[inline(always)]
fn tell_indices<const MANY: bool>(
    low: &[u8],
    high: &[u8],
    layout: &Layout,
    row: &mut [u8],
    indices: &mut [u16],
) {
    layout.gather(low, row);
    for (index, &low) in indices.iter_mut().zip(&*row) {
        *index = low.into();
    }
    if MANY {
        layout.gather(high, row);
        for (index, &high) in indices.iter_mut().zip(&*row) {
            *index |= u16::from(high) << u8::BITS;
        }
    }
}
