//! Many questions at once: slices in, slices out, by several threads where there are some.

#[cfg(not(feature = "parallel"))]
use crate::simd::exactly;
#[cfg(feature = "parallel")]
use {crate::threads::Exactly, rayon::prelude::*};

/// Chunks of so many questions with their answers side by side, in the caller's pool where there is one. The slices are as long
/// as each other.
pub(crate) fn each_chunk<Q: Sync, A: Send>(
    chunk: usize,
    questions: &[Q],
    answers: &mut [A],
    work: impl Fn(&[Q], &mut [A]) + Send + Sync,
) {
    #[cfg(feature = "parallel")]
    questions
        .par_chunks(chunk)
        .zip(answers.par_chunks_mut(chunk))
        .exactly()
        .for_each(|(questions, answers)| work(questions, answers));
    #[cfg(not(feature = "parallel"))]
    exactly(|| {
        let chunks = questions.chunks(chunk).zip(answers.chunks_mut(chunk));
        chunks.for_each(|(questions, answers)| work(questions, answers));
    });
}

/// Chunks of two lists side by side, each with the place of its first items, in the caller's pool where there is one. The
/// lists are as long as each other.
pub(crate) fn each_pair<A: Send, B: Send>(
    chunk: usize,
    first: &mut [A],
    second: &mut [B],
    work: impl Fn(usize, &mut [A], &mut [B]) + Send + Sync,
) {
    debug_assert_eq!(first.len(), second.len());
    #[cfg(feature = "parallel")]
    first
        .par_chunks_mut(chunk)
        .zip(second.par_chunks_mut(chunk))
        .enumerate()
        .exactly()
        .for_each(|(i, (first, second))| work(i * chunk, first, second));
    #[cfg(not(feature = "parallel"))]
    exactly(|| {
        let chunks = first.chunks_mut(chunk).zip(second.chunks_mut(chunk));
        for (i, (first, second)) in chunks.enumerate() {
            work(i * chunk, first, second);
        }
    });
}
