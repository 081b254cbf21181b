import sys, flint
flint.ctx.prec=200
from certificates.container import read
from certificates.checker import Certificate
from certificates.container import load
import certificates.cells as C, certificates.searches as cs
from certificates.polynomials import *
from certificates.geometry import Turned
from certificates import guess
c=Certificate(load(sys.argv[1])); k=int(sys.argv[2]); n=int(sys.argv[3])-1
from certificates.subsets import classify
s=c.searches(k,classify(c.problem,c.subsets[k]))
se,l=s.leaves[n]
print(l.node,l.cell.bounds,[b-a for a,b in l.cell.bounds],l.cell.side,l.data)
for r in se.roots:
    if r.chart==l.cell.chart: print('root',r.pose,[((a+b)/2,(b-a)/2) for a,b in r.box[:3]])
u=[between(rational(a),rational(b),i) for i,(a,b) in enumerate(l.cell.bounds[:3])]
T=Turned(se.platform,l.cell.chart,u)
x=C.on_branch(T,l.cell.side)
print('x',None if x is None else [(number(centre(v)),[f'{number(w):.1e}' for w in slopes(v,range(7))]) for v in x])
P=C.Place(T,x,True); w=T.wrenches(x)
rows=[[number(centre(v)) for v in q] for q in w]
y=[float(v) for v in l.data]; 
print('const', [guess.inner(y,r) for r in rows], 'scale',[sum(abs(a*b) for a,b in zip(y,r)) for r in rows])
forms=[dot([constant(rational(v)) for v in y],q) for q in w]
print('rad',[number(centre(f)-lowest(P.freed(f))) for f in forms])
print(P.unbalanced(l.data))
