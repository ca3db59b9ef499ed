//! What a sweep goes over: slices of one length, alone or in a tuple, each `&` or `&mut`.
//!
//! Threads share where the slices lie and take the elements one by one. Splitting the slices instead, as zipped
//! parallel iterators do, is the same loop in the end, and takes twice as long to compile for each of them.

use std::marker::PhantomData;

/// `&[T]`, `&mut [T]`, or a tuple of such.
pub trait Columns {
    /// The elements at one index.
    type Item;
    /// Where the elements lie.
    type Places: Copy + Send + Sync;

    /// The length of the slices.
    fn length(&self) -> usize;

    fn places(self) -> Self::Places;

    /// The elements at an index.
    ///
    /// # Safety
    /// The index is below the length and is asked for once.
    unsafe fn at(places: Self::Places, index: usize) -> Self::Item;
}

impl<'a, T: Sync> Columns for &'a [T] {
    type Item = &'a T;
    type Places = &'a [T];

    #[inline(always)]
    fn length(&self) -> usize {
        self.len()
    }

    #[inline(always)]
    fn places(self) -> Self::Places {
        self
    }

    #[inline(always)]
    unsafe fn at(places: Self::Places, index: usize) -> Self::Item {
        // SAFETY: the index is below the length.
        unsafe { places.get_unchecked(index) }
    }
}

/// The first of the elements that a thread may write.
pub struct First<'a, T>(*mut T, PhantomData<&'a mut [T]>);

impl<T> Clone for First<'_, T> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<T> Copy for First<'_, T> {}

// SAFETY: it stands for a `&mut [T]`, whose elements go to one thread each.
unsafe impl<T: Send> Send for First<'_, T> {}
// SAFETY: as above.
unsafe impl<T: Send> Sync for First<'_, T> {}

impl<'a, T: Send> Columns for &'a mut [T] {
    type Item = &'a mut T;
    type Places = First<'a, T>;

    #[inline(always)]
    fn length(&self) -> usize {
        self.len()
    }

    #[inline(always)]
    fn places(self) -> Self::Places {
        First(self.as_mut_ptr(), PhantomData)
    }

    #[inline(always)]
    unsafe fn at(places: Self::Places, index: usize) -> Self::Item {
        // SAFETY: the index is below the length, and no other reference to this element is made.
        unsafe { &mut *places.0.add(index) }
    }
}

macro_rules! tuple_of_columns {
    ($first:ident $($column:ident)*) => {
        #[allow(non_snake_case, reason = "a type and what is of it have one name")]
        impl<$first: Columns, $($column: Columns),*> Columns for ($first, $($column),*) {
            type Item = ($first::Item, $($column::Item),*);
            type Places = ($first::Places, $($column::Places),*);

            #[inline(always)]
            fn length(&self) -> usize {
                let ($first, $($column),*) = self;
                let length = $first.length();
                $(assert_eq!($column.length(), length, "columns of different lengths");)*
                length
            }

            #[inline(always)]
            fn places(self) -> Self::Places {
                let ($first, $($column),*) = self;
                ($first.places(), $($column.places()),*)
            }

            #[inline(always)]
            unsafe fn at(places: Self::Places, index: usize) -> Self::Item {
                let ($first, $($column),*) = places;
                // SAFETY: what is asked of the caller, and the lengths are the same.
                unsafe { ($first::at($first, index), $($column::at($column, index)),*) }
            }
        }
    };
}
tuple_of_columns!(A B);
tuple_of_columns!(A B C);
tuple_of_columns!(A B C D);
tuple_of_columns!(A B C D E F);
