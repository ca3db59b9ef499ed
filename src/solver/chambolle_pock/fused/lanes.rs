//! What the pass needs of single and double precision: vectors of the instruction set S, lane by lane.
//!
//! With AVX2 and AVX-512 a product and a sum are rounded once, in the same places, so that they give the same bits;
//! portable code rounds twice.

use pulp::bytemuck::{Pod, cast_slice, cast_slice_mut};
use pulp::{Arch, Simd};

type V<T, S> = <T as Real>::Vector<S>;

pub trait Real: Pod + Send + Sync {
    type Vector<S: Simd>: Pod;

    const ZERO: Self;
    /// Whether this is the precision of everything else.
    const DOUBLE: bool;
    /// What sums of numbers near 1 do not notice, and far from what is too small to be a normal number.
    const NEGLIGIBLE: f64;
    /// The distance from 1 to the next number.
    const EPSILON: f64;

    fn from_f64(x: f64) -> Self;
    fn to_f64(self) -> f64;

    fn splat<S: Simd>(simd: S, x: f64) -> V<Self, S>;
    fn add<S: Simd>(simd: S, a: V<Self, S>, b: V<Self, S>) -> V<Self, S>;
    fn sub<S: Simd>(simd: S, a: V<Self, S>, b: V<Self, S>) -> V<Self, S>;
    fn mul<S: Simd>(simd: S, a: V<Self, S>, b: V<Self, S>) -> V<Self, S>;
    /// a b + c
    fn mul_add<S: Simd>(simd: S, a: V<Self, S>, b: V<Self, S>, c: V<Self, S>) -> V<Self, S>;
    fn neg<S: Simd>(simd: S, a: V<Self, S>) -> V<Self, S>;
    fn div<S: Simd>(simd: S, a: V<Self, S>, b: V<Self, S>) -> V<Self, S>;
    fn min<S: Simd>(simd: S, a: V<Self, S>, b: V<Self, S>) -> V<Self, S>;
    fn max<S: Simd>(simd: S, a: V<Self, S>, b: V<Self, S>) -> V<Self, S>;
    fn sqrt<S: Simd>(simd: S, a: V<Self, S>) -> V<Self, S>;
    /// a < b ? c : d
    fn if_less<S: Simd>(
        simd: S,
        a: V<Self, S>,
        b: V<Self, S>,
        c: V<Self, S>,
        d: V<Self, S>,
    ) -> V<Self, S>;
    /// Whether a < b in any lane.
    fn any_less<S: Simd>(simd: S, a: V<Self, S>, b: V<Self, S>) -> bool;
    /// The largest of all lanes.
    fn largest<S: Simd>(simd: S, a: V<Self, S>) -> f64;
    /// Rows of four, one after the other, to four vectors with a lane for each row; lanes in the order of
    /// [`lane_order`].
    fn deinterleave<S: Simd>(simd: S, rows: [V<Self, S>; 4]) -> [V<Self, S>; 4];
    /// And back.
    fn interleave<S: Simd>(simd: S, lanes: [V<Self, S>; 4]) -> [V<Self, S>; 4];
}

/// As many lanes as any vector has.
pub const WIDEST: usize = 16;

/// How many lanes a vector has.
pub const fn width<T: Real, S: Simd>() -> usize {
    size_of::<T::Vector<S>>() / size_of::<T>()
}

/// The square of what is below lambda, however it is rounded.
pub fn surely_inside<T: Real>(lambda: f64) -> f64 {
    lambda.powi(2) * (1.0 - 8.0 * T::EPSILON)
}

/// Rows of four, one after the other, as many as a vector has lanes.
#[inline(always)]
pub fn gather<T: Real, S: Simd>(simd: S, row: impl Fn(usize) -> [T; 4]) -> [V<T, S>; 4] {
    let mut rows = [T::splat(simd, 0.0); 4];
    for (o, place) in cast_slice_mut::<_, [T; 4]>(&mut rows).iter_mut().enumerate() {
        *place = row(o);
    }
    rows
}

/// The lane in which [`Real::deinterleave`] puts each row.
pub fn lane_order<T: Real>(arch: Arch) -> Vec<usize> {
    struct Order<T>(std::marker::PhantomData<T>);
    impl<T: Real> pulp::WithSimd for Order<T> {
        type Output = Vec<usize>;

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> Vec<usize> {
            let lanes = T::deinterleave(simd, gather(simd, |o| [T::from_f64(o as f64); 4]));
            let row_in: &[T] = cast_slice(&lanes[..1]);
            let mut order = vec![0; row_in.len()];
            for (lane, row) in row_in.iter().enumerate() {
                order[row.to_f64() as usize] = lane;
            }
            order
        }
    }
    arch.dispatch(Order::<T>(std::marker::PhantomData))
}

macro_rules! real {
    ($float:ty, $negligible:expr, $vector:ident, $splat:ident, $add:ident, $sub:ident, $mul:ident, $mul_add:ident,
     $neg:ident, $div:ident, $min:ident, $max:ident, $sqrt:ident, $less:ident, $select:ident, $first:ident,
     $largest:ident, $deinterleave:ident, $interleave:ident) => {
        impl Real for $float {
            type Vector<S: Simd> = S::$vector;

            const ZERO: Self = 0.0;
            const DOUBLE: bool = size_of::<Self>() == size_of::<f64>();
            const NEGLIGIBLE: f64 = $negligible;
            const EPSILON: f64 = <$float>::EPSILON as f64;

            #[inline(always)]
            fn from_f64(x: f64) -> Self {
                x as $float
            }
            #[inline(always)]
            fn to_f64(self) -> f64 {
                f64::from(self)
            }
            #[inline(always)]
            fn splat<S: Simd>(simd: S, x: f64) -> S::$vector {
                simd.$splat(x as $float)
            }
            #[inline(always)]
            fn add<S: Simd>(simd: S, a: S::$vector, b: S::$vector) -> S::$vector {
                simd.$add(a, b)
            }
            #[inline(always)]
            fn sub<S: Simd>(simd: S, a: S::$vector, b: S::$vector) -> S::$vector {
                simd.$sub(a, b)
            }
            #[inline(always)]
            fn mul<S: Simd>(simd: S, a: S::$vector, b: S::$vector) -> S::$vector {
                simd.$mul(a, b)
            }
            #[inline(always)]
            fn mul_add<S: Simd>(
                simd: S,
                a: S::$vector,
                b: S::$vector,
                c: S::$vector,
            ) -> S::$vector {
                simd.$mul_add(a, b, c)
            }
            #[inline(always)]
            fn neg<S: Simd>(simd: S, a: S::$vector) -> S::$vector {
                simd.$neg(a)
            }
            #[inline(always)]
            fn div<S: Simd>(simd: S, a: S::$vector, b: S::$vector) -> S::$vector {
                simd.$div(a, b)
            }
            #[inline(always)]
            fn min<S: Simd>(simd: S, a: S::$vector, b: S::$vector) -> S::$vector {
                simd.$min(a, b)
            }
            #[inline(always)]
            fn max<S: Simd>(simd: S, a: S::$vector, b: S::$vector) -> S::$vector {
                simd.$max(a, b)
            }
            #[inline(always)]
            fn sqrt<S: Simd>(simd: S, a: S::$vector) -> S::$vector {
                simd.$sqrt(a)
            }
            #[inline(always)]
            fn if_less<S: Simd>(
                simd: S,
                a: S::$vector,
                b: S::$vector,
                c: S::$vector,
                d: S::$vector,
            ) -> S::$vector {
                simd.$select(simd.$less(a, b), c, d)
            }
            #[inline(always)]
            fn any_less<S: Simd>(simd: S, a: S::$vector, b: S::$vector) -> bool {
                simd.$first(simd.$less(a, b)) < width::<Self, S>()
            }
            #[inline(always)]
            fn largest<S: Simd>(simd: S, a: S::$vector) -> f64 {
                f64::from(simd.$largest(a))
            }
            #[inline(always)]
            fn deinterleave<S: Simd>(simd: S, rows: [S::$vector; 4]) -> [S::$vector; 4] {
                simd.$deinterleave(rows)
            }
            #[inline(always)]
            fn interleave<S: Simd>(simd: S, lanes: [S::$vector; 4]) -> [S::$vector; 4] {
                simd.$interleave(lanes)
            }
        }
    };
}

real!(
    f32,
    1e-13,
    f32s,
    splat_f32s,
    add_f32s,
    sub_f32s,
    mul_f32s,
    mul_add_e_f32s,
    neg_f32s,
    div_f32s,
    min_f32s,
    max_f32s,
    sqrt_f32s,
    less_than_f32s,
    select_f32s,
    first_true_m32s,
    reduce_max_f32s,
    deinterleave_shfl_f32s,
    interleave_shfl_f32s
);
real!(
    f64,
    1e-60,
    f64s,
    splat_f64s,
    add_f64s,
    sub_f64s,
    mul_f64s,
    mul_add_e_f64s,
    neg_f64s,
    div_f64s,
    min_f64s,
    max_f64s,
    sqrt_f64s,
    less_than_f64s,
    select_f64s,
    first_true_m64s,
    reduce_max_f64s,
    deinterleave_shfl_f64s,
    interleave_shfl_f64s
);
