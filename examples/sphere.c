/* A calibrator in C: the sphere through the measurements, |m - b|^2 = r^2, by linear least squares.
 *
 *   cc -O2 -o sphere-c examples/sphere.c -lm
 *   magbench calibrate log.csv --exec './sphere-c {recording.csv} {result} {field_strength_nT}'
 *
 * With u = m / F it solves 2 u . c + k = |u|^2 for the centre c = b / F and k = (r / F)^2 - |c|^2. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { UNKNOWNS = 4, LONGEST_LINE = 1 << 16 };

static void fail(const char *what) {
    fprintf(stderr, "%s\n", what);
    exit(1);
}

/* The number of a column, from 0, by its name in the header. */
static int column_of(const char *header, const char *name) {
    size_t length = strlen(name);
    int column = 0;
    for (const char *at = header; at; at = strchr(at, ','), at = at ? at + 1 : NULL, column++)
        if (!strncmp(at, name, length) && strchr(",\r\n", at[length])) return column;
    fail("a column of the field is missing");
    return -1;
}

/* The value in a column of a line; no value is told as NaN. */
static double value_at(const char *line, int column) {
    char *end;
    while (line && column-- > 0) line = (line = strchr(line, ',')) ? line + 1 : NULL;
    if (!line) return NAN;
    double value = strtod(line, &end);
    return end == line ? NAN : value;
}

/* Solve N x = r by elimination with pivots; N and r are used up. */
static void solve(double N[UNKNOWNS][UNKNOWNS], double r[UNKNOWNS], double x[UNKNOWNS]) {
    for (int k = 0; k < UNKNOWNS; k++) {
        int best = k;
        for (int i = k + 1; i < UNKNOWNS; i++)
            if (fabs(N[i][k]) > fabs(N[best][k])) best = i;
        if (fabs(N[best][k]) < 1e-12 * fabs(N[0][0])) fail("the measurements lie in a plane");
        for (int j = 0; j < UNKNOWNS; j++) {
            double kept = N[k][j];
            N[k][j] = N[best][j];
            N[best][j] = kept;
        }
        double kept = r[k];
        r[k] = r[best];
        r[best] = kept;
        for (int i = k + 1; i < UNKNOWNS; i++) {
            double share = N[i][k] / N[k][k];
            for (int j = k; j < UNKNOWNS; j++) N[i][j] -= share * N[k][j];
            r[i] -= share * r[k];
        }
    }
    for (int k = UNKNOWNS - 1; k >= 0; k--) {
        x[k] = r[k];
        for (int j = k + 1; j < UNKNOWNS; j++) x[k] -= N[k][j] * x[j];
        x[k] /= N[k][k];
    }
}

int main(int count, char **words) {
    static char line[LONGEST_LINE];
    double N[UNKNOWNS][UNKNOWNS] = {{0}}, r[UNKNOWNS] = {0}, x[UNKNOWNS];
    int columns[3];
    if (count != 4) fail("usage: sphere-c RECORDING.csv RESULT.json FIELD_STRENGTH_NT");
    double strength_nT = atof(words[3]);
    FILE *recording = fopen(words[1], "r");
    if (!recording || !fgets(line, sizeof line, recording)) fail("the recording cannot be read");
    columns[0] = column_of(line, "mag_x_nT");
    columns[1] = column_of(line, "mag_y_nT");
    columns[2] = column_of(line, "mag_z_nT");
    while (fgets(line, sizeof line, recording)) {
        double row[UNKNOWNS] = {0, 0, 0, 1}, square = 0;
        for (int i = 0; i < 3; i++) {
            double u = value_at(line, columns[i]) / strength_nT;
            row[i] = 2 * u;
            square += u * u;
        }
        if (!isfinite(square)) continue; /* no measurement in this row */
        for (int i = 0; i < UNKNOWNS; i++) {
            for (int j = 0; j < UNKNOWNS; j++) N[i][j] += row[i] * row[j];
            r[i] += row[i] * square;
        }
    }
    fclose(recording);
    solve(N, r, x);
    double scale = 1 / sqrt(x[3] + x[0] * x[0] + x[1] * x[1] + x[2] * x[2]);
    FILE *result = fopen(words[2], "w");
    if (!result) fail("the result cannot be written");
    fprintf(result, "{\"offset_nT\": [%.17g, %.17g, %.17g], ", strength_nT * x[0], strength_nT * x[1],
            strength_nT * x[2]);
    fprintf(result, "\"matrix\": [[%.17g, 0, 0], [0, %.17g, 0], [0, 0, %.17g]]}\n", scale, scale, scale);
    return fclose(result);
}
