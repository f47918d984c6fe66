//! Work by several threads, each of which computes [exactly].
//!
//! *How it works.* Every thread has a float mode of its own, and those of a pool have it from whoever started them. So what
//! rayon's threads are given looks at the mode when it begins: halves in [`join`], and pieces of a parallel iterator after
//! [`Exactly::exactly`]. What follows that call is covered (maps, folds, what joins two results); what precedes it should
//! only number and cut, and what takes several side by side (`zip`, `chunks`) belongs before it.

use crate::simd::exactly;
use rayon::iter::plumbing::{
    Consumer, Folder, Producer, ProducerCallback, Reducer, UnindexedConsumer,
};
use rayon::iter::{IndexedParallelIterator, ParallelIterator};

/// [`rayon::join`] of two halves.
pub fn join<A: Send, B: Send>(
    a: impl FnOnce() -> A + Send,
    b: impl FnOnce() -> B + Send,
) -> (A, B) {
    rayon::join(|| exactly(a), || exactly(b))
}

/// What is done with the items is done exactly.
pub trait Exactly: ParallelIterator {
    /// The same items.
    fn exactly(self) -> Exact<Self> {
        Exact(self)
    }
}
impl<I: ParallelIterator> Exactly for I {}

/// See [`Exactly::exactly`].
#[derive(Clone)]
pub struct Exact<T>(T);

impl<I: ParallelIterator> ParallelIterator for Exact<I> {
    type Item = I::Item;
    fn drive_unindexed<C: UnindexedConsumer<I::Item>>(self, consumer: C) -> C::Result {
        self.0.drive_unindexed(Exact(consumer))
    }
    fn opt_len(&self) -> Option<usize> {
        self.0.opt_len()
    }
}

impl<I: IndexedParallelIterator> IndexedParallelIterator for Exact<I> {
    fn len(&self) -> usize {
        self.0.len()
    }
    fn drive<C: Consumer<I::Item>>(self, consumer: C) -> C::Result {
        self.0.drive(Exact(consumer))
    }
    fn with_producer<B: ProducerCallback<I::Item>>(self, callback: B) -> B::Output {
        self.0.with_producer(Exact(callback))
    }
}

impl<T, B: ProducerCallback<T>> ProducerCallback<T> for Exact<B> {
    type Output = B::Output;
    fn callback<P: Producer<Item = T>>(self, producer: P) -> B::Output {
        self.0.callback(Exact(producer))
    }
}

impl<P: Producer> Producer for Exact<P> {
    type Item = P::Item;
    type IntoIter = P::IntoIter;
    fn into_iter(self) -> P::IntoIter {
        self.0.into_iter()
    }
    fn min_len(&self) -> usize {
        self.0.min_len()
    }
    fn max_len(&self) -> usize {
        self.0.max_len()
    }
    fn split_at(self, index: usize) -> (Self, Self) {
        let (left, right) = self.0.split_at(index);
        (Exact(left), Exact(right))
    }
    fn fold_with<F: Folder<P::Item>>(self, folder: F) -> F {
        exactly(|| self.0.fold_with(folder))
    }
}

impl<T, C: Consumer<T>> Consumer<T> for Exact<C> {
    type Folder = Exact<C::Folder>;
    type Reducer = Exact<C::Reducer>;
    type Result = C::Result;
    fn split_at(self, index: usize) -> (Self, Self, Self::Reducer) {
        let (left, right, reducer) = self.0.split_at(index);
        (Exact(left), Exact(right), Exact(reducer))
    }
    fn into_folder(self) -> Self::Folder {
        Exact(exactly(|| self.0.into_folder()))
    }
    fn full(&self) -> bool {
        self.0.full()
    }
}

impl<T, C: UnindexedConsumer<T>> UnindexedConsumer<T> for Exact<C> {
    fn split_off_left(&self) -> Self {
        Exact(self.0.split_off_left())
    }
    fn to_reducer(&self) -> Self::Reducer {
        Exact(self.0.to_reducer())
    }
}

impl<T, F: Folder<T>> Folder<T> for Exact<F> {
    type Result = F::Result;
    fn consume(self, item: T) -> Self {
        Exact(exactly(|| self.0.consume(item)))
    }
    fn consume_iter<I: IntoIterator<Item = T>>(self, items: I) -> Self {
        Exact(exactly(|| self.0.consume_iter(items)))
    }
    fn complete(self) -> F::Result {
        exactly(|| self.0.complete())
    }
    fn full(&self) -> bool {
        self.0.full()
    }
}

impl<T, R: Reducer<T>> Reducer<T> for Exact<R> {
    fn reduce(self, left: T, right: T) -> T {
        exactly(|| self.0.reduce(left, right))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::hint::black_box;
    use rayon::prelude::*;

    /// 1 where the thread computes exactly: subnormal results are kept and 5/3 is rounded down.
    fn exact() -> usize {
        let [least, half, three] = black_box([f32::MIN_POSITIVE, 0.5, 3.0]);
        usize::from(least * half > 0.0 && 5.0 / three < 1.666_666_7)
    }

    #[test]
    fn threads_of_careless_callers_compute_exactly() {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(3)
            .spawn_handler(|thread| {
                #[allow(unsafe_code, reason = "to set a mode is a promise")]
                // SAFETY: only `exact` computes with floats, of what the compiler does not know, and looks at them.
                std::thread::spawn(|| unsafe { crate::simd::carelessly(|| thread.run()) });
                Ok(())
            })
            .build()
            .expect("the system gives threads");
        let careless = pool.install(exact) == 0;
        assert!(careless || !cfg!(target_arch = "x86_64"));
        let sum = |a: usize, b: usize| a + b + exact() - 1;
        let found = pool.install(|| {
            let items = (0..1000).into_par_iter().exactly().map(|_| exact());
            let all: Vec<usize> = items.clone().collect();
            let reduced = items.reduce(|| 0, sum);
            (all, reduced, join(exact, exact))
        });
        assert_eq!(found, (vec![1; 1000], 1000, (1, 1)));
    }
}
