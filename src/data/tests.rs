//! Properties of every data model.

use super::constant::Mean;
use super::l1::Median;
use super::{DataModel, L1, PiecewiseConstant, Weights};
use crate::field::Row;
use crate::samples::{random_data, random_labels, rng};

/// Regions beyond those of the model are padding, whose costs `regions.rs` sets.
#[test]
fn padded_regions_have_no_parameters() {
    fn check<D: DataModel>(model: &D, mu: D::Parameters, seed: u64) {
        let mut mu = vec![mu; 9];
        model.fit(Weights::of(&random_labels::<12>(4, 9, &mut rng(seed))), &mut mu).unwrap();
        assert_eq!(mu.len(), 9);
        assert!(model.costs::<12>(&mu).iter().all(|s| s.0[9..] == [0.0; 3]));
    }
    check(&PiecewiseConstant::new(&random_data(4, 1, 121)), Mean { mean: vec![0.5] }, 123);
    check(&L1::new(&random_data(4, 1, 131)), Median { median: vec![0.5] }, 133);
}

#[test]
fn an_empty_region_keeps_its_parameters() {
    fn check<D: DataModel>(model: &D, parameters: impl Fn(Vec<f64>) -> D::Parameters) {
        let mut mu = [parameters(vec![0.1; 2]), parameters(vec![7.0, -3.0])];
        let change = model.fit(Weights::of(&[Row([0.2, 0.0]); 5]), &mut mu).unwrap();
        let [moved, kept] = mu.each_ref().map(D::value);
        assert_eq!(kept, [7.0, -3.0]);
        assert_eq!(change, f64::max((moved[0] - 0.1).abs(), (moved[1] - 0.1).abs()));
        assert!(change > 0.0);
    }
    check(&PiecewiseConstant::new(&random_data(5, 2, 121)), |mean| Mean { mean });
    check(&L1::new(&random_data(5, 2, 131)), |median| Median { median });
}
